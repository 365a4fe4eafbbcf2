"""Connections to published results.

A published file is a snapshot: it is written aside and renamed, so that a reader sees all of one snapshot and
is never blocked. A connection can only read: the file is attached read-only, no other file can be opened, and
the configuration is locked.
"""

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries.database import schema
from queries.database.place import DATABASE, ResultsError, duckdb_path, locate, quote, reason

MEMORY = "128MB"
"""Memory limit of DuckDB for figures and report."""
_SMALL_BYTES = 2**28
"""File size below which more than one thread makes figures and report slower."""


def connect(
    named: Path | str, other: Path | str | None = None, bounded: bool = False, memory: str | None = None
) -> duckdb.DuckDBPyConnection:
    """Return a connection that can only read the published results of a run directory or a database file.

    Parameters
    ----------
    named
        Run directory or database file.
    other
        Another one, whose tables and views appear with the prefix `other.`.
    bounded, memory
        See `attach`.

    Raises
    ------
    ResultsError
        If there is no run directory, no database in it, or the file cannot be read by this version.
    """
    other_file = None if other is None else _published_file(other)
    return attach(_published_file(named), other_file, bounded=bounded, memory=memory)


def _published_file(named: Path | str) -> Path:
    path = locate(named).path
    if not path.exists():
        raise ResultsError(
            f"{named}: holds no {DATABASE} yet; `railvib ingest {named}` makes it from the records"
        )
    return path


def attach(
    path: Path,
    other: Path | None = None,
    any_form: bool = False,
    bounded: bool = False,
    memory: str | None = None,
) -> duckdb.DuckDBPyConnection:
    """Return a read-only connection to one database file, or to two.

    The file is attached to a new connection rather than opened: within a process DuckDB shares opened files
    by name, and would show the old snapshot after a new one has replaced it.

    Parameters
    ----------
    path, other
        The files; unqualified names belong to the first, the second has the prefix `other.`.
    any_form
        Accept a file whose tables and views are those of another version.
    bounded
        Limit the memory to MEMORY, whatever the size of the file; the rest is spilled to a folder beside the
        file, or to the system's. Otherwise nothing is written.
    memory
        Largest memory of a query, such as "1GB". By default that of the machine.

    Raises
    ------
    ResultsError
        If a file cannot be read, or is no database of results of this version.
    """
    config: dict[str, Any] = {
        "python_enable_replacements": False,
        "temp_directory": _spill_folder(path) if bounded else "",
        "preserve_insertion_order": True,
    }
    if bounded:
        memory = memory or MEMORY
        if path.exists() and path.stat().st_size <= _SMALL_BYTES:
            config["threads"] = 1
    if memory is not None:
        config["memory_limit"] = memory
    connection = duckdb.connect(":memory:", config=config)
    files = [(path, "results")] if other is None else [(other, "other"), (path, "results")]
    try:
        for file, name in files:
            try:
                connection.execute(f"ATTACH {quote(duckdb_path(file))} AS {name} (READ_ONLY)")
                connection.execute(f"USE {name}")
                if not any_form:
                    _check_version(connection, file)
            except duckdb.Error as error:
                raise ResultsError(f"{file}: cannot be read: {reason(error)}") from error
        connection.execute("SET enable_external_access = false")
        connection.execute("SET autoinstall_known_extensions = false")
        connection.execute("SET autoload_known_extensions = false")
        connection.execute("SET lock_configuration = true")
    except BaseException:
        connection.close()
        raise
    return connection


def _spill_folder(path: Path) -> str:
    beside = os.access(path.parent, os.W_OK)
    return f"{path.absolute() if beside else Path(tempfile.gettempdir()) / path.name}.tmp"


def _check_version(connection: duckdb.DuckDBPyConnection, path: Path) -> None:
    """Refuse a file whose tables or views are not those of this version."""
    check_form(connection, path)
    if not is_present_form(connection):
        raise ResultsError(
            f"{path}: is of an earlier railvib (form {schema.version(connection)} of {schema.latest()}); "
            "`railvib ingest` brings it up to date"
        )


def check_form(connection: duckdb.DuckDBPyConnection, path: Path) -> None:
    """Refuse a file that is no database of results, or that a newer version has written.

    Raises
    ------
    ResultsError
        If it is.
    """
    version = schema.version(connection)
    if version == 0:
        raise ResultsError(f"{path}: is no database of results")
    if version > schema.latest():
        raise ResultsError(
            f"{path}: is of form {version}, written by a newer railvib; this one knows form {schema.latest()}"
        )


def is_present_form(connection: duckdb.DuckDBPyConnection) -> bool:
    """Return whether a file has the tables and views of this version."""
    forms = connection.execute("SELECT DISTINCT form FROM schema_version").fetchall()
    return schema.version(connection) == schema.latest() and forms == [(schema.form_id(),)]


def snapshot(connection: duckdb.DuckDBPyConnection) -> tuple[str, str]:
    """Return digests of the records behind a database, and of what its levels and figures depend on."""
    records = "SELECT md5(string_agg(fingerprint, '' ORDER BY source)) FROM sources"
    row = connection.execute(f"SELECT ({records}), results FROM snapshot").fetchone()
    return (str(row[0]), str(row[1])) if row else ("", "")


def fetch_columns(
    connection: duckdb.DuckDBPyConnection, query: str, parameters: Sequence[Any] | Mapping[str, Any] = ()
) -> dict[str, NDArray[Any]]:
    """Return the columns of a query as arrays; NULL becomes NaN among numbers."""
    columns = connection.execute(query, parameters).fetchnumpy()
    return {name: fill_gaps(column) for name, column in columns.items()}


def fill_gaps(column: Any) -> NDArray[Any]:
    """Return a column as DuckDB gives it, with NaN in place of NULL among floats and 0 among integers."""
    if isinstance(column, np.ma.MaskedArray) and column.dtype.kind in "fiu":
        return np.asarray(column.filled(np.nan if column.dtype.kind == "f" else 0))
    return np.asarray(column)
