"""From records and store to results.duckdb: published in one step, and left alone while nothing changed."""

import hashlib
import json
import os
import shutil
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import duckdb

from queries import arrays, database
from queries.database import DATABASE, ResultsError
from queries.manifests import Contents, Row, contents, utc
from queries.rows import Writer
from sweep import records

_ABANDONED_S = 3600.0
"""Age from which the unfinished file of another process counts as left behind."""

_FROM_ARRAYS = ("series", "psd_lines", "bands", "receptances", "ingested")
"""Tables filled from the store, unit by unit; all others are small and made anew each time."""


@dataclass(frozen=True)
class Ingest:
    """What an ingest did: the file, whether it changed, and committed units whose arrays cannot be read."""

    path: Path
    changed: bool
    unreadable: tuple[str, ...] = ()


def ingest(directory: Path | str, rebuild: bool = False) -> Ingest:
    """Derive results.duckdb of a run directory from its records and its store, unless it is up to date.

    The file is built aside and put in its place by one rename: readers see the old snapshot or the new one,
    and an ingest that is killed leaves the old one. Rows of units that are in the old snapshot already are
    kept, for they cannot change.

    Parameters
    ----------
    directory
        Output directory of a run.
    rebuild
        Make it anew from the records and the store alone.

    Raises
    ------
    ResultsError
        If the directory does not hold a run.
    """
    directory = Path(directory)
    database.check_run(directory)
    path = directory / DATABASE
    manifests = records.runs(directory) or [records.Run.load(directory)]
    failures = list(records.failed(directory))
    present = records.present(directory)
    fingerprint = _digest(database.form(), sorted(present), manifests, failures)
    if not rebuild and _published(path) == fingerprint:
        return Ingest(path, changed=False)
    _remove_abandoned(path)
    said = contents(manifests)
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    log = partial.with_name(f"{partial.name}.wal")
    try:
        partial.unlink(missing_ok=True)
        if rebuild or not _kept(path, said, present):
            connection = database.create(partial)
        else:
            shutil.copyfile(path, partial)
            connection = database.create(partial, keep=_FROM_ARRAYS)
        with connection:
            connection.begin()
            unreadable = _fill(connection, directory, said, failures)
            results = _digest(database.form(), _ingested(connection), said.shown())
            connection.execute("INSERT INTO snapshot VALUES (?, ?)", [fingerprint, results])
            connection.commit()
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
        log.unlink(missing_ok=True)
    return Ingest(path, changed=True, unreadable=tuple(unreadable))


def _digest(*parts: Any) -> str:
    """Return the sha256 over everything a snapshot depends on.

    Records are immutable and named by their content, so that their names suffice.
    """
    digest = hashlib.sha256()
    for part in parts:
        digest.update(json.dumps(part, sort_keys=True).encode())
    return digest.hexdigest()


def _published(path: Path) -> str | None:
    """Return the fingerprint of the published snapshot, or None where there is none that can be read."""
    try:
        with database.attach(path) as connection:
            row = connection.execute("SELECT fingerprint FROM snapshot").fetchone()
    except (ResultsError, duckdb.Error):
        return None
    return row[0] if row else None


def _kept(path: Path, said: Contents, present: set[str]) -> bool:
    """Return whether all rows from arrays in the published snapshot still hold, so that they can be kept."""
    try:
        with database.attach(path) as connection:
            form = connection.execute("SELECT form FROM schema_version LIMIT 1").fetchone()
            old = _ingested(connection)
    except (ResultsError, duckdb.Error):
        return False
    return form == (database.form_id(),) and all(
        unit in present and unit in said.owners and said.key(unit) == key for unit, key in old.items()
    )


def _ingested(connection: duckdb.DuckDBPyConnection) -> dict[str, str]:
    return dict(connection.execute("SELECT unit_id, key FROM ingested ORDER BY unit_id").fetchall())


def _remove_abandoned(path: Path) -> None:
    """Remove what ingests that were killed left beside the database."""
    for leftover in path.parent.glob(f"{path.name}.*.partial*"):
        if time.time() - leftover.stat().st_mtime > _ABANDONED_S:
            leftover.unlink(missing_ok=True)


def _fill(
    connection: duckdb.DuckDBPyConnection, directory: Path, said: Contents, failures: Iterable[Row]
) -> list[str]:
    """Fill the tables, and return the committed units whose arrays cannot be read."""
    writer = Writer(connection)
    for table, rows in said.tables.items():
        writer.rows(table, rows)
    failed = [_failure(record) for record in failures]
    units: list[Row] = []
    costs: list[Row] = []
    keys: list[Row] = []
    ingested = _ingested(connection)
    unreadable: list[str] = []
    for record in records.committed(directory):
        unit = record["unit_id"]
        if record["kind"] in arrays.KINDS and unit in said.owners and unit not in ingested:
            fault = arrays.insert(writer, directory, record, said)
            if fault is not None:
                failed.append(_failure({**record, "traceback": fault}))
                unreadable.append(unit)
                continue
            keys.append({"unit_id": unit, "key": said.key(unit)})
        units.append(
            {**record, "started": utc(record.get("started")), "finished": utc(record.get("finished"))}
        )
        costs += [{**record, **cost} for cost in record.get("costs", [])]
    writer.rows("ingested", keys)
    writer.rows("units", units)
    writer.rows("unit_costs", costs)
    writer.rows("failures", failed)
    return unreadable


def _failure(record: Row) -> Row:
    lines = str(record.get("traceback", "")).strip().splitlines()
    return {
        **record,
        "error": lines[-1] if lines else "",
        "started": utc(record.get("started")),
        "finished": utc(record.get("finished")),
    }
