"""Replacing a database file: the new one is written aside, reopened and counted, and renamed.

The old file stays until the new one is known to be whole.
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
"""Age from which another process's unfinished file counts as abandoned."""
_MARGIN_BYTES = 2**24
"""Space that must be free beyond that of the copy."""


def aside(path: Path, purpose: str = "") -> Path:
    """Return the name of the file in which this process prepares another one."""
    return path.with_name(f"{path.name}.{os.getpid()}{purpose}.partial")


def check_space(path: Path) -> None:
    """Check that there is space for a copy of a file.

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
    """Move a finished file to its place, after checking that a reader finds all of its rows.

    Parameters
    ----------
    partial
        The file, closed.
    path
        Its place.
    counts
        Rows of every table that its writer has inserted.
    backup
        Name under which the replaced file is kept.

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
    """Return the file offset in bytes at which the last block with rows ends."""
    last = -1
    for table in tables:
        row = connection.execute("SELECT max(block_id) FROM pragma_storage_info($1)", [table]).fetchone()
        last = max(last, int(row[0]) if row and row[0] is not None else -1)
    row = connection.execute("SELECT any_value(block_size) FROM pragma_database_size()").fetchone()
    return (last + 1) * int(row[0]) if row else 0


def _keep(path: Path, backup: Path) -> None:
    """Link a file to a second name, or copy it where links are not supported."""
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
    """Remove files that killed processes left beside a database."""
    for leftover in path.parent.glob(f"{path.name}.*.partial*"):
        with suppress(FileNotFoundError):
            if time.time() - leftover.stat().st_mtime > _ABANDONED_S:
                leftover.unlink()


def _log(partial: Path) -> Path:
    """Return DuckDB's write-ahead log of a database file."""
    return partial.with_name(f"{partial.name}.wal")
