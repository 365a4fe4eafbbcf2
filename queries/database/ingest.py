"""From records and store to a database: published in one step, and left alone while nothing changed."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import duckdb

from queries.database import filling, replacement, schema
from queries.database.place import ResultsError, duckdb_path, locate, reason
from queries.database.sources import Published, Source

_TROUBLE = (OSError, duckdb.OperationalError, duckdb.FatalException)
"""Errors of disks and memory, as against errors of a program."""


@dataclass(frozen=True)
class Ingest:
    """What an ingest did.

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
    """Make the empty database that the first ingest of a run directory fills, and return its file."""
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

    The file is built aside and put in its place by one rename: readers see the old snapshot or the new one,
    and an ingest that fails or is killed leaves the old one. Rows of units that are in the old snapshot
    already are kept, for they cannot change; so are those of run directories that are not named.

    Parameters
    ----------
    directories
        Run directories; none: those that `file` has, as far as they are still there.
    rebuild
        Make the file anew, from the records and stores of `directories` alone.
    file
        The database; by default that of the one run directory.
    begun
        An empty database, if `begin` has made one; it is used up.

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
    """Return the run directories that a file has, as far as they are still there."""
    directories = [path.parent / name for name in (before.fingerprints if before else ())]
    present = [directory for directory in directories if directory.is_dir()]
    if not present:
        raise ResultsError(f"{path}: no run directory is named, and the file has none that is still there")
    return present


def _replace(path: Path, before: Published | None, sources: Sequence[Source], begun: Path | None) -> Ingest:
    """Write a database aside, from the one before if there is any, and put it in place."""
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
            connection.execute("CHECKPOINT")  # closing would do it as well, and would not say if it fails
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
    """Return what is known of a file; None for none, and for a broken one that can be derived anew."""
    try:
        return Published.read(path)
    except ResultsError:
        if derivable and path.is_file():
            return None
        raise
