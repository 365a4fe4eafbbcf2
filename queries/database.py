"""The results database of a run directory: where it lies, how it is made and how it is read.

What is published is a snapshot: it is written aside and put in place by one rename, so a reader has all of
one snapshot and is never blocked. Every connection for reading is closed in itself: the file is attached
read-only, no other file can be reached, and the configuration cannot be changed.
"""

import hashlib
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

import duckdb

DATABASE = "results.duckdb"
STORAGE_VERSION = "v1.4.0"
"""Oldest DuckDB whose readers open the files; newer ones read them as well."""


class ResultsError(Exception):
    """A request about results that cannot be met; its message is one line."""


def create(path: Path, keep: Sequence[str] = ()) -> duckdb.DuckDBPyConnection:
    """Create a database file with all tables and views, and return a connection for writing it.

    Parameters
    ----------
    path
        The file.
    keep
        If given, the file is there in its present form, and all tables but these are emptied.
    """
    connection = duckdb.connect(str(path), config={"storage_compatibility_version": STORAGE_VERSION})
    connection.begin()  # hundreds of statements: one by one, each would wait for the disk
    if keep:
        tables = connection.execute("SELECT table_name FROM duckdb_tables()").fetchall()
        for (table,) in tables:
            if table not in (*keep, "schema_version"):
                connection.execute(f"DELETE FROM {table}")
    else:
        for version, name, text in migrations():
            connection.execute(text)
            connection.execute("INSERT INTO schema_version VALUES (?, ?, ?)", [version, name, form_id()])
        connection.execute(_views())
    connection.commit()
    return connection


def migrations() -> list[tuple[int, str, str]]:
    """Return number, name and SQL of every migration, in their order."""
    folder = resources.files("queries") / "migrations"
    files = sorted((file for file in folder.iterdir() if file.name[:3].isdigit()), key=lambda file: file.name)
    return [(int(file.name[:3]), file.name.removesuffix(".sql")[4:], file.read_text()) for file in files]


def form() -> str:
    """Return the SQL of all tables and views: what the form of a file follows from."""
    return "\n".join([*(text for _, _, text in migrations()), _views()])


def form_id() -> str:
    """Return the sha256 of `form`."""
    return hashlib.sha256(form().encode()).hexdigest()


def _views() -> str:
    return (resources.files("queries") / "migrations" / "views.sql").read_text()


def connect(directory: Path | str) -> duckdb.DuckDBPyConnection:
    """Return a connection that can only read the published snapshot of a run directory.

    Raises
    ------
    ResultsError
        If there is no run directory, no database in it, or the file cannot be opened.
    """
    path = Path(directory) / DATABASE
    check_run(directory)
    if not path.is_file():
        raise ResultsError(
            f"{directory}: holds no {DATABASE} yet; `railvib ingest {directory}` makes it from the records"
        )
    return attach(path)


def attach(path: Path) -> duckdb.DuckDBPyConnection:
    """Return a read-only connection to one database file.

    The file is attached to a connection of its own rather than opened: DuckDB shares an opened file within a
    process by its name, which would show the old snapshot after a new one has taken its place.
    """
    connection = duckdb.connect(
        ":memory:",
        config={"python_enable_replacements": False, "temp_directory": "", "preserve_insertion_order": True},
    )
    try:
        name = str(path).replace("'", "''")
        connection.execute(f"ATTACH '{name}' AS results (READ_ONLY)")
        connection.execute("USE results")
        connection.execute("SET enable_external_access = false")
        connection.execute("SET autoinstall_known_extensions = false")
        connection.execute("SET autoload_known_extensions = false")
        connection.execute("SET lock_configuration = true")
    except duckdb.Error as error:
        connection.close()
        raise ResultsError(f"{path}: cannot be read: {str(error).splitlines()[0]}") from error
    return connection


def check_run(directory: Path | str) -> None:
    """Refuse what is not the output directory of a run.

    Raises
    ------
    ResultsError
        If the directory is missing or holds no run.
    """
    if not Path(directory).is_dir():
        raise ResultsError(f"{directory}: no such directory")
    if not (Path(directory) / "run.json").is_file():
        raise ResultsError(f"{directory}: is not the output directory of a run, it holds no run.json")
