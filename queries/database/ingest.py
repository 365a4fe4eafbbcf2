"""Ingest of records and store into a database, which is replaced in one step, and only after changes."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import duckdb

from queries.database import filling, replacement, schema
from queries.database.place import ResultsError, duckdb_path, locate, reason
from queries.database.sources import Published, Source

_TROUBLE = (OSError, duckdb.OperationalError, duckdb.FatalException)
"""Errors of disk and memory, not of the program."""


@dataclass(frozen=True)
class Ingest:
    """The outcome of an ingest.

    Attributes
    ----------
    path
        The database.
    changed
        Whether it was written.
    unreadable
        Committed units whose arrays cannot be read, each with its run directory.
    backup
        Copy of a file of an earlier form, made before it was brought up to date.
    """

    path: Path
    changed: bool
    unreadable: tuple[tuple[Path, str], ...] = ()
    backup: Path | None = None


def begin(directory: Path | str) -> Path:
    """Create the empty database for the first ingest of a run directory, and return its file."""
    path = locate(directory).path
    begun = replacement.aside(path, ".begun")
    if not path.exists():
        begun.unlink(missing_ok=True)
        schema.create(begun).close()
    return begun


def ingest(
    directories: Path | str | Sequence[Path | str],
    rebuild: bool = False,
    file: Path | str | None = None,
    begun: Path | None = None,
) -> Ingest:
    """Derive a database from the records and stores of run directories, unless it is up to date.

    The file is built aside and renamed: readers see the old snapshot or the new one, and a failed or killed
    ingest leaves the old one. Rows of units that are in the old snapshot are kept, as they cannot change; so
    are those of run directories that are not named.

    Parameters
    ----------
    directories
        Run directories; if empty, those of `file` that still exist.
    rebuild
        Build the file from the records and stores of `directories` alone.
    file
        The database; by default that of the one run directory.
    begun
        The empty database of `begin`, if there is one; it is moved into place.

    Raises
    ------
    ResultsError
        If a directory does not hold a run, the file is of a newer version or no database of results, or it
        cannot be written.
    """
    named = [
        Path(directory)
        for directory in ([directories] if isinstance(directories, Path | str) else directories)
    ]
    if file is None and len(named) != 1:
        raise ResultsError(
            "the results of several run directories go to a file of their own: --database FILE"
        )
    path = Path(file) if file is not None else locate(named[0]).path
    duckdb_path(path)
    before = _read_published(path, derivable=file is None)
    if rebuild:
        before = None
    sources = [Source.read(directory, path) for directory in dict.fromkeys(named or _sources(path, before))]
    if before is not None and all(before.has(source) for source in sources):
        return Ingest(path, changed=False)
    try:
        return _replace(path, before, sources, begun)
    except _TROUBLE as error:
        raise ResultsError(f"{path}: cannot be written: {reason(error)}") from error


def _sources(path: Path, before: Published | None) -> list[Path]:
    """Return the run directories of a file that still exist."""
    directories = [path.parent / name for name in (before.fingerprints if before else ())]
    present = [directory for directory in directories if directory.is_dir()]
    if not present:
        raise ResultsError(f"{path}: no run directory is named, and the file has none that is still there")
    return present


def _replace(path: Path, before: Published | None, sources: Sequence[Source], begun: Path | None) -> Ingest:
    """Write a database aside, starting from the present one if any, and put it in place."""
    replacement.remove_abandoned(path)
    replacement.check_space(path)
    partial = replacement.aside(path)
    backup = None
    try:
        partial.unlink(missing_ok=True)
        if before is not None:
            shutil.copyfile(path, partial)
            connection = schema.open_for_writing(partial)
        elif begun is not None and begun.exists():
            begun.replace(partial)
            connection = schema.open_for_writing(partial)
        else:
            connection = schema.create(partial)
        with connection:
            if before is not None and not before.present_form:
                schema.upgrade(connection)
            if before is not None and before.version < schema.latest():
                backup = path.with_name(f"{path.stem}.form-{before.version}{path.suffix}")
            connection.begin()
            unreadable = [
                (source.directory, unit) for source in sources for unit in filling.fill(connection, source)
            ]
            filling.finish(connection)
            connection.commit()
            counts = replacement.row_counts(connection)
            connection.execute("CHECKPOINT")  # closing would do this too, but hide a failure
        replacement.put_in_place(partial, path, counts, backup)
    finally:
        replacement.remove(partial)
    return Ingest(path, True, tuple(unreadable), backup)


def is_outdated(directory: Path | str) -> bool:
    """Return whether the database of a run directory lacks something that its records have."""
    path = locate(directory).path
    before = _read_published(path, derivable=True)
    return before is None or not before.has(Source.read(Path(directory), path))


def _read_published(path: Path, derivable: bool) -> Published | None:
    """Return the state of a file; None if it is missing, or broken and can be rebuilt."""
    try:
        return Published.read(path)
    except ResultsError:
        if derivable and path.is_file():
            return None
        raise
