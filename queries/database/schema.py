"""The schema of a results database: numbered migrations of its tables, and the views on top.

Tables change through migrations only, and a released migration never changes: an older file gets those that
it lacks. Views hold no data, so they are dropped and created again where a file's differ.
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
"""Oldest DuckDB that can read the files; newer ones can too."""

_FOLDER = resources.files("queries.database") / "migrations"
_SQL = statements("queries.database", "schema")


def create(path: Path) -> duckdb.DuckDBPyConnection:
    """Create a database file with all tables and views, and return a connection for writing it."""
    connection = open_for_writing(path)
    upgrade(connection)
    return connection


def open_for_writing(path: Path) -> duckdb.DuckDBPyConnection:
    """Return a connection that writes a file in the storage format of the oldest supported reader."""
    # Rows come from NumPy one stretch after another: more threads would only wait.
    config: dict[str, Any] = {"storage_compatibility_version": STORAGE_VERSION, "threads": 1}
    connection = duckdb.connect(duckdb_path(path), config=config)
    # Compression hardly shrinks narrow-band lines, and takes an eighth of the writing time.
    connection.execute("SET disabled_compression_methods = 'alprd'")
    return connection


def upgrade(connection: duckdb.DuckDBPyConnection) -> None:
    """Apply missing migrations and create the views of this version, in one transaction."""
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
        with suppress(duckdb.Error):  # its own error would hide the first one
            connection.rollback()
        raise


def version(connection: duckdb.DuckDBPyConnection) -> int:
    """Return the number of a file's last migration; 0 if it has none."""
    if connection.execute(_SQL["has-versions"]).fetchone() is None:
        return 0
    row = connection.execute("SELECT max(version) FROM schema_version").fetchone()
    return int(row[0] or 0) if row else 0


@cache
def latest() -> int:
    """Return the number of this version's last migration."""
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
    """Drop every view and macro of a file; views first, as they use macros."""
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
