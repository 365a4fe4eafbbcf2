"""Where results lie and how they are read: the database of a run directory, or one file of many runs.

What is published is a snapshot: it is written aside and put in place by one rename, so a reader has all of
one snapshot and is never blocked. Every connection for reading is closed in itself: the file is attached
read-only, no other file can be reached, and the configuration cannot be changed.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import duckdb

from queries.database import schema

DATABASE = "results.duckdb"
MEMORY = "128MB"
"""What figures and report take of a database at a time."""
_SMALL_BYTES = 2**28
"""Size of a file up to which threads of a connection cost figures and report more than they save."""


class ResultsError(Exception):
    """A request about results that cannot be met; its message is one line."""


@dataclass(frozen=True)
class Place:
    """Where results lie: a database file, and what is made of it beside it.

    Attributes
    ----------
    named
        What the user called it.
    path
        The database file.
    directory
        The run directory whose own database it is; None for a file of its own.
    """

    named: Path
    path: Path
    directory: Path | None

    @property
    def figures(self) -> Path:
        """Folder of the figures."""
        return self._beside("figures", "-figures")

    @property
    def report(self) -> Path:
        """File of the report."""
        return self._beside("report.html", ".html")

    def _beside(self, within: str, ending: str) -> Path:
        return self.directory / within if self.directory else self.path.with_name(self.path.stem + ending)


def locate(named: Path | str) -> Place:
    """Return where the results lie that a user names: a run directory or a database file.

    Raises
    ------
    ResultsError
        If it is neither.
    """
    named = Path(named)
    if named.is_file():
        return Place(named, named, None)
    check_run(named)
    return Place(named, named / DATABASE, named)


def connect(
    named: Path | str, other: Path | str | None = None, bounded: bool = False
) -> duckdb.DuckDBPyConnection:
    """Return a connection that can only read the published results of a run directory or a database file.

    Parameters
    ----------
    named
        Run directory or database file.
    other
        Another one, whose tables and views appear with the prefix `other.`.
    bounded
        Keep memory bounded, see `attach`.

    Raises
    ------
    ResultsError
        If there is no run directory, no database in it, or the file cannot be read by this version.
    """
    return attach(_published(named), None if other is None else _published(other), bounded=bounded)


def _published(named: Path | str) -> Path:
    path = locate(named).path
    if not path.is_file():
        raise ResultsError(
            f"{named}: holds no {DATABASE} yet; `railvib ingest {named}` makes it from the records"
        )
    return path


def attach(
    path: Path, other: Path | None = None, anyform: bool = False, bounded: bool = False
) -> duckdb.DuckDBPyConnection:
    """Return a read-only connection to one database file, or to two.

    The file is attached to a connection of its own rather than opened: DuckDB shares an opened file within a
    process by its name, which would show the old snapshot after a new one has taken its place.

    Parameters
    ----------
    path, other
        The files; the first is the one that names mean, the second has the prefix `other.`.
    anyform
        Accept a file whose tables and views are those of another version.
    bounded
        Hold no more than MEMORY of the file and of what is made of it, whatever its size; what is beyond it
        goes to a folder beside the file. Otherwise nothing is written, and memory is what the machine has.
    """
    config: dict[str, Any] = {
        "python_enable_replacements": False,
        "temp_directory": f"{path}.tmp" if bounded else "",
        "preserve_insertion_order": True,
    }
    if bounded:
        config["memory_limit"] = MEMORY
        if path.exists() and path.stat().st_size <= _SMALL_BYTES:
            config["threads"] = 1
    connection = duckdb.connect(":memory:", config=config)
    at = path
    try:
        for at, name in (*([] if other is None else [(other, "other")]), (path, "results")):
            quoted = str(at).replace("'", "''")
            connection.execute(f"ATTACH '{quoted}' AS {name} (READ_ONLY)")
            connection.execute(f"USE {name}")
            if not anyform:
                _check_version(connection, at)
        connection.execute("SET enable_external_access = false")
        connection.execute("SET autoinstall_known_extensions = false")
        connection.execute("SET autoload_known_extensions = false")
        connection.execute("SET lock_configuration = true")
    except duckdb.Error as error:
        connection.close()
        raise ResultsError(f"{at}: cannot be read: {str(error).splitlines()[0]}") from error
    except ResultsError:
        connection.close()
        raise
    return connection


def _check_version(connection: duckdb.DuckDBPyConnection, path: Path) -> None:
    """Refuse a file whose tables or views are not those of this version."""
    found = schema.version(connection)
    if found == 0:
        raise ResultsError(f"{path}: is no database of results")
    if found > schema.latest():
        raise ResultsError(
            f"{path}: is of form {found}, written by a newer railvib; this one knows form {schema.latest()}"
        )
    if not is_present_form(connection):
        raise ResultsError(
            f"{path}: is of an earlier railvib (form {found} of {schema.latest()}); "
            "`railvib ingest` brings it up to date"
        )


def is_present_form(connection: duckdb.DuckDBPyConnection) -> bool:
    """Return whether a file has the tables and views of this version."""
    forms = connection.execute("SELECT DISTINCT form FROM schema_version").fetchall()
    return schema.version(connection) == schema.latest() and forms == [(schema.form_id(),)]


def snapshot(connection: duckdb.DuckDBPyConnection) -> tuple[str, str]:
    """Return digests of the records behind a database, and of what its levels and figures depend on."""
    row = connection.execute(
        "SELECT (SELECT md5(string_agg(fingerprint, '' ORDER BY source)) FROM sources), results FROM snapshot"
    ).fetchone()
    return (str(row[0]), str(row[1])) if row else ("", "")


def check_run(directory: Path | str) -> None:
    """Refuse what is not the output directory of a run.

    Raises
    ------
    ResultsError
        If the directory is missing or holds no run.
    """
    if not Path(directory).is_dir():
        raise ResultsError(f"{directory}: no such directory or database file")
    if not (Path(directory) / "run.json").is_file():
        raise ResultsError(f"{directory}: is not the output directory of a run, it holds no run.json")
