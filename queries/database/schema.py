"""The form of a results database: numbered migrations of its tables, and the views on top.

Tables change through migrations alone, which never change once released: a file of an older version gets
those that it lacks. Views hold nothing, so they are dropped and made anew where a file's differ.
"""

import hashlib
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import duckdb

from queries.database.place import duckdb_path
from queries.statements import statements

STORAGE_VERSION = "v1.4.0"
"""Oldest DuckDB whose readers open the files; newer ones read them as well."""

_FOLDER = resources.files("queries.database") / "migrations"
_SQL = statements("queries.database", "schema")


def create(path: Path) -> duckdb.DuckDBPyConnection:
    """Create a database file with all tables and views, and return a connection for writing it."""
    connection = open_for_writing(path)
    upgrade(connection)
    return connection


def open_for_writing(path: Path) -> duckdb.DuckDBPyConnection:
    """Return a connection that writes a file in the storage format of the oldest supported reader."""
    # Rows come from NumPy one stretch after the other: more threads would only wait for each other.
    config: dict[str, Any] = {"storage_compatibility_version": STORAGE_VERSION, "threads": 1}
    connection = duckdb.connect(duckdb_path(path), config=config)
    # It makes narrow-band lines hardly smaller, and takes an eighth of the time to write them.
    connection.execute("SET disabled_compression_methods = 'alprd'")
    return connection


def upgrade(connection: duckdb.DuckDBPyConnection) -> None:
    """Give a file the migrations that it lacks, and the views of this version, in one transaction."""
    connection.begin()
    try:
        present = version(connection)
        for number, name, text in migrations():
            if number > present:
                connection.execute(text)
                connection.execute("INSERT INTO schema_version VALUES (?, ?, NULL)", [number, name])
        if present:
            _drop_views(connection)
        connection.execute(_text("views.sql"))
        connection.execute(";".join(_view_comments(connection)))
        connection.execute("UPDATE schema_version SET form = ?", [form_id()])
        connection.commit()
    except BaseException:
        with suppress(duckdb.Error):  # an error of its own would hide the first one
            connection.rollback()
        raise


def version(connection: duckdb.DuckDBPyConnection) -> int:
    """Return the number of the last migration that a file has had; 0 for a file without any."""
    if connection.execute(_SQL["has-versions"]).fetchone() is None:
        return 0
    row = connection.execute("SELECT max(version) FROM schema_version").fetchone()
    return int(row[0] or 0) if row else 0


@cache
def latest() -> int:
    """Return the number of the last migration that this version knows."""
    return migrations()[-1][0]


@cache
def migrations() -> list[tuple[int, str, str]]:
    """Return number, name and SQL of every migration, in their order."""
    files = sorted(
        (file for file in _FOLDER.iterdir() if file.name[:3].isdigit()), key=lambda file: file.name
    )
    return [
        (int(file.name[:3]), file.name.removesuffix(".sql")[4:], file.read_text("utf-8")) for file in files
    ]


@cache
def form_id() -> str:
    """Return the sha256 of the SQL of all tables and views, and of their comments."""
    texts = [*(text for _, _, text in migrations()), _text("views.sql"), _text("comments.toml")]
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()


def _text(name: str) -> str:
    return (_FOLDER / name).read_text("utf-8")


def _drop_views(connection: duckdb.DuckDBPyConnection) -> None:
    """Drop every view and macro of a file; the views first, for they use macros."""
    for (name,) in connection.execute(_SQL["views"]).fetchall():
        connection.execute(f'DROP VIEW "{name}"')
    for name, kind in connection.execute(_SQL["macros"]).fetchall():
        connection.execute(f'DROP MACRO {"TABLE " if kind == "table_macro" else ""}"{name}"')


def _view_comments(connection: duckdb.DuckDBPyConnection) -> Iterator[str]:
    """Yield the statements that comment the views and their columns."""
    comments: dict[str, dict[str, Any]] = tomllib.loads(_text("comments.toml"))
    for view, column in connection.execute(_SQL["columns-of-views"]).fetchall():
        of_view = comments["views"].get(view, {})
        text = of_view.get("") if column is None else of_view.get(column, comments["columns"].get(column))
        if text is not None:
            thing = f'VIEW "{view}"' if column is None else f'COLUMN "{view}"."{column}"'
            yield f"COMMENT ON {thing} IS '{text.replace(chr(39), chr(39) * 2)}'"
