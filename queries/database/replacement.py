"""Replacing a database file: by one that is written aside, opened and counted again, and renamed.

What a file held before stays until its successor is known to be whole.
"""

import os
import shutil
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path

import duckdb

from queries.database.connection import attach
from queries.database.place import ResultsError

_ABANDONED_S = 3600.0
"""Age from which the unfinished file of another process counts as left behind."""
_MARGIN_BYTES = 2**24
"""Space that must be free beyond what is copied."""


def aside(path: Path, purpose: str = "") -> Path:
    """Return the name of the file in which this process prepares another one."""
    return path.with_name(f"{path.name}.{os.getpid()}{purpose}.partial")


def check_space(path: Path) -> None:
    """Refuse to begin where the copy of a file would not fit.

    Raises
    ------
    ResultsError
        Naming the space that is needed and that is free.
    """
    needed = _MARGIN_BYTES + (path.stat().st_size if path.exists() else 0)
    free = shutil.disk_usage(path.parent).free
    if free < needed:
        raise ResultsError(
            f"{path}: writing it takes at least {needed / 1e6:,.0f} MB, only {free / 1e6:,.0f} MB are free"
        )


def row_counts(connection: duckdb.DuckDBPyConnection) -> dict[str, int]:
    """Return the number of rows of every table of the current database."""
    query = "SELECT table_name FROM duckdb_tables() WHERE database_name = current_database()"
    counts = {}
    for (table,) in connection.execute(query).fetchall():
        row = connection.execute(f"SELECT count(*) FROM {table}").fetchone()
        counts[table] = int(row[0]) if row else 0
    return counts


def put_in_place(partial: Path, path: Path, counts: Mapping[str, int], backup: Path | None = None) -> None:
    """Give a finished file its place, if a reader finds all of its rows.

    Parameters
    ----------
    partial
        The file, closed.
    path
        Its place.
    counts
        Rows of every table that its writer has inserted.
    backup
        Another name that the file before keeps.

    Raises
    ------
    ResultsError
        If rows are missing.
    """
    with partial.open("rb+") as file:
        os.fsync(file.fileno())
    with attach(partial) as connection:
        whole = row_counts(connection) == counts and _end(connection, counts) <= partial.stat().st_size
    if not whole or _log(partial).exists():
        raise ResultsError(f"{path}: the new file is not whole, so the one before stays")
    if backup is not None:
        _keep(path, backup)
    partial.replace(path)


def _end(connection: duckdb.DuckDBPyConnection, tables: Iterable[str]) -> int:
    """Return where the last block with rows of the current database ends in its file, byte."""
    last = -1
    for table in tables:
        row = connection.execute("SELECT max(block_id) FROM pragma_storage_info($1)", [table]).fetchone()
        last = max(last, int(row[0]) if row and row[0] is not None else -1)
    row = connection.execute("SELECT any_value(block_size) FROM pragma_database_size()").fetchone()
    return (last + 1) * int(row[0]) if row else 0


def _keep(path: Path, backup: Path) -> None:
    """Give a file another name, or copy it where a file has one name only."""
    backup.unlink(missing_ok=True)
    try:
        os.link(path, backup)
    except OSError:
        shutil.copyfile(path, backup)


def remove(partial: Path) -> None:
    """Remove an unfinished file, if it is there, and its log."""
    for file in (partial, _log(partial)):
        with suppress(OSError):
            file.unlink(missing_ok=True)


def remove_abandoned(path: Path) -> None:
    """Remove what processes that were killed left beside a database."""
    for leftover in path.parent.glob(f"{path.name}.*.partial*"):
        with suppress(FileNotFoundError):
            if time.time() - leftover.stat().st_mtime > _ABANDONED_S:
                leftover.unlink()


def _log(partial: Path) -> Path:
    """Return the file in which DuckDB keeps what is not in the database file yet."""
    return partial.with_name(f"{partial.name}.wal")
