"""State of run directories and database files: fingerprints show whether an ingest is needed."""

import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import duckdb

from queries.database import schema
from queries.database.connection import attach, check_form, is_present_form
from queries.database.place import ResultsError, check_run, reason
from sweep.storage import records

_FIRST_WITH_SOURCES = 2
"""Version from which files store run directories."""


@dataclass(frozen=True)
class Source:
    """A run directory as it is now.

    Attributes
    ----------
    directory
        Its path.
    name
        Its path in the database: relative to the database's folder if inside it, else absolute.
    manifests
        Of all runs, the earliest first.
    failures
        Records of failures.
    present
        Ids of all committed units.
    fingerprint
        sha256 over all of these.
    """

    directory: Path
    name: str
    manifests: list[dict[str, Any]]
    failures: list[dict[str, Any]]
    present: set[str]
    fingerprint: str

    @staticmethod
    def read(directory: Path, path: Path) -> "Source":
        """Return a run directory for the database at a path.

        Raises
        ------
        ResultsError
            If the directory holds no run, or no manifest of it can be read.
        """
        check_run(directory)
        try:
            manifests = records.runs(directory) or [records.Run.load(directory)]
        except FileNotFoundError:
            raise ResultsError(f"{directory}: no manifest of a run can be read") from None
        failures = list(records.failures(directory))
        present = records.ids_of(directory)
        # Records are immutable and named by content, so their names suffice.
        text = json.dumps([sorted(present), manifests, failures], sort_keys=True)
        fingerprint = hashlib.sha256(text.encode()).hexdigest()
        absolute, folder = (Path(os.path.realpath(path_name)) for path_name in (directory, path.parent))
        name = absolute.relative_to(folder) if absolute.is_relative_to(folder) else absolute
        return Source(directory, str(name), manifests, failures, present, fingerprint)


@dataclass(frozen=True)
class Published:
    """A database file as it is now.

    Attributes
    ----------
    version
        Number of its last migration.
    present_form
        Whether its tables and views are those of this version.
    fingerprints
        Fingerprints of its run directories, by name; None in versions that did not store them.
    """

    version: int
    present_form: bool
    fingerprints: dict[str, str | None]

    def has(self, source: Source) -> bool:
        """Return whether all rows of a run directory are there, in the form of this version."""
        return self.present_form and self.fingerprints.get(source.name) == source.fingerprint

    @staticmethod
    def read(path: Path) -> "Published | None":
        """Return the state of a file, or None if there is none.

        Raises
        ------
        ResultsError
            If it cannot be read, is no database of results, or of a newer version.
        """
        if not path.exists():
            return None
        with attach(path, any_form=True) as connection:
            check_form(connection, path)
            version = schema.version(connection)
            known = version >= _FIRST_WITH_SOURCES
            try:
                query = "SELECT directory, fingerprint FROM sources"
                fingerprints = dict(connection.execute(query).fetchall()) if known else {}
                return Published(version, is_present_form(connection), fingerprints)
            except duckdb.Error as error:
                raise ResultsError(f"{path}: cannot be read: {reason(error)}") from error
