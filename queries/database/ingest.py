"""From records and store to a database: published in one step, and left alone while nothing changed."""

import hashlib
import json
import os
import shutil
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import duckdb

from queries.database import arrays, parameters, schema
from queries.database import connection as database
from queries.database.connection import ResultsError
from queries.database.manifests import Contents, Row, contents, utc
from queries.database.rows import Writer
from sweep.storage import records

_ABANDONED_S = 3600.0
"""Age from which the unfinished file of another process counts as left behind."""

_FROM_ARRAYS = ("bands", "receptances", "series", "ingested")
"""Tables filled from the store, unit by unit; psd_lines follows series."""

_MEMORY = "64MB"
"""What DuckDB may hold of the rows from arrays, whose number has no bound; the rest is in the file."""

_FROM_RECORDS = ("units", "unit_costs", "failures")


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


@dataclass(frozen=True)
class _Source:
    """A run directory as it is now."""

    directory: Path
    name: str
    manifests: list[dict[str, Any]]
    failures: list[dict[str, Any]]
    present: set[str]
    fingerprint: str


def begin(directory: Path | str) -> Path:
    """Make the empty database that the first ingest of a run directory fills, and return its file."""
    path = database.locate(directory).path
    begun = path.with_name(f"{path.name}.{os.getpid()}.begun.partial")
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
    and an ingest that is killed leaves the old one. Rows of units that are in the old snapshot already are
    kept, for they cannot change; so are those of run directories that are not named.

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
        If a directory does not hold a run, or the file is of a newer version or no database of results.
    """
    named = [Path(each) for each in ([directories] if isinstance(directories, Path | str) else directories)]
    if file is None and len(named) != 1:
        raise ResultsError(
            "the results of several run directories go to a file of their own: --database FILE"
        )
    path = Path(file) if file is not None else database.locate(named[0]).path
    for directory in named:
        database.check_run(directory)
    before = None if rebuild else _Published.read(path, own=file is None)
    if not named:
        named = [path.parent / name for name in (before.fingerprints if before else ())]
        named = [directory for directory in named if directory.is_dir()]
        if not named:
            raise ResultsError(
                f"{path}: no run directory is named, and the file has none that is still there"
            )
    sources = [_source(directory, path) for directory in dict.fromkeys(named)]
    if before is not None and before.present_form:
        if all(before.fingerprints.get(source.name) == source.fingerprint for source in sources):
            return Ingest(path, changed=False)
    _remove_abandoned(path)
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    log = partial.with_name(f"{partial.name}.wal")
    backup = None
    try:
        partial.unlink(missing_ok=True)
        if before is None and begun is not None and begun.exists():
            begun.replace(partial)
            connection = schema.open_for_writing(partial)
        elif before is None:
            connection = schema.create(partial)
        else:
            if before.version < schema.latest():
                backup = path.with_name(f"{path.stem}.form-{before.version}{path.suffix}")
                shutil.copyfile(path, backup)
            shutil.copyfile(path, partial)
            connection = schema.open_for_writing(partial)
        with connection:
            if before is not None and not before.present_form:
                schema.upgrade(connection)
            connection.begin()
            unreadable = [
                (source.directory, unit) for source in sources for unit in _fill(connection, source)
            ]
            _number_runs(connection)
            connection.execute("DELETE FROM snapshot")
            connection.execute("INSERT INTO snapshot VALUES (?)", [_results(connection)])
            connection.commit()
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
        log.unlink(missing_ok=True)
    return Ingest(path, True, tuple(unreadable), backup)


def is_outdated(directory: Path | str) -> bool:
    """Return whether the database of a run directory lacks something that its records have."""
    path = database.locate(directory).path
    before = _Published.read(path, own=True)
    source = _source(Path(directory), path)
    return (
        before is None
        or not before.present_form
        or before.fingerprints.get(source.name) != source.fingerprint
    )


@dataclass(frozen=True)
class _Published:
    """What a published file is: number and sameness of its form, and fingerprints of what it has."""

    version: int
    present_form: bool
    fingerprints: dict[str, str | None]

    @staticmethod
    def read(path: Path, own: bool) -> "_Published | None":
        """Return what a file is; None for none, and for a broken one that can be derived anew."""
        if not path.exists():
            return None
        try:
            with database.attach(path, anyform=True) as connection:
                version = schema.version(connection)
                if version == 0:
                    raise ResultsError(f"{path}: is no database of results")
                if version > schema.latest():
                    raise ResultsError(
                        f"{path}: is of form {version}, written by a newer railvib; "
                        f"this one knows form {schema.latest()}"
                    )
                known = version > 1
                rows = (
                    connection.execute("SELECT directory, fingerprint FROM sources").fetchall()
                    if known
                    else []
                )
                return _Published(version, database.is_present_form(connection), dict(rows))
        except (ResultsError, duckdb.Error) as error:
            if own:
                return None
            raise ResultsError(str(error).splitlines()[0]) from error


def _source(directory: Path, path: Path) -> _Source:
    manifests = records.runs(directory) or [records.Run.load(directory)]
    failures = list(records.failed(directory))
    present = records.present(directory)
    # Records are immutable and named by their content, so that their names suffice.
    text = json.dumps([sorted(present), manifests, failures], sort_keys=True)
    fingerprint = hashlib.sha256(text.encode()).hexdigest()
    there, folder = directory.resolve(), path.parent.resolve()
    inside = there.relative_to(folder) if there.is_relative_to(folder) else there
    return _Source(directory, str(inside), manifests, failures, present, fingerprint)


def _remove_abandoned(path: Path) -> None:
    """Remove what ingests that were killed left beside the database."""
    for leftover in path.parent.glob(f"{path.name}.*.partial*"):
        if time.time() - leftover.stat().st_mtime > _ABANDONED_S:
            leftover.unlink(missing_ok=True)


def _fill(connection: duckdb.DuckDBPyConnection, source: _Source) -> list[str]:
    """Bring the rows of one run directory up to date; return its units whose arrays cannot be read."""
    said = contents(source.manifests)
    number = _number(connection, source)
    for table in _FROM_RECORDS:
        connection.execute(f"DELETE FROM {table} WHERE source = ?", [number])
    _drop_stale(connection, number, source, said)
    _name(connection, number, said)
    writer = Writer(connection)
    reader = arrays.Reader(writer, source.directory, number, said)
    query = "SELECT unit_id FROM ingested WHERE source = ?"
    ingested = {row[0] for row in connection.execute(query, [number]).fetchall()}
    failed = [_failure(record) for record in source.failures]
    units: list[Row] = []
    costs: list[Row] = []
    connection.execute(f"SET memory_limit = '{_MEMORY}'")
    keys: list[Row] = []
    unreadable: list[str] = []
    for record in records.committed(source.directory):
        unit = record["unit_id"]
        if record["kind"] in arrays.TAKEN and unit in said.owners and unit not in ingested:
            fault = reader.take(record)
            if fault is not None:
                failed.append(_failure({**record, "traceback": fault}))
                unreadable.append(unit)
                continue
            keys.append({"unit_id": unit, "key": said.key(unit)})
        units.append(
            {**record, "started": utc(record.get("started")), "finished": utc(record.get("finished"))}
        )
        costs += [{**record, **cost} for cost in record.get("costs", [])]
    writer.flush()
    connection.execute("RESET memory_limit")
    for table, rows in (("ingested", keys), ("units", units), ("unit_costs", costs), ("failures", failed)):
        writer.rows(table, [{**row, "source": number} for row in rows])
    return unreadable


def _number(connection: duckdb.DuckDBPyConnection, source: _Source) -> int:
    """Return the number of a run directory in the file, a new one if it was not there."""
    row = connection.execute("SELECT source FROM sources WHERE directory = ?", [source.name]).fetchone()
    if row is None:
        row = connection.execute("SELECT coalesce(max(source), 0) + 1 FROM sources").fetchone()
        assert row is not None
        connection.execute("INSERT INTO sources VALUES (?, ?, NULL)", [row[0], source.name])
    connection.execute("UPDATE sources SET fingerprint = ? WHERE source = ?", [source.fingerprint, row[0]])
    return int(row[0])


def _drop_stale(connection: duckdb.DuckDBPyConnection, number: int, source: _Source, said: Contents) -> None:
    """Drop the rows from arrays of units that are no longer there, or serve other cases than they did."""
    rows = connection.execute("SELECT unit_id, key FROM ingested WHERE source = ?", [number]).fetchall()
    stale = [
        unit
        for unit, key in rows
        if unit not in source.present or unit not in said.owners or said.key(unit) != key
    ]
    if not stale:
        return
    which = "WHERE source = $1 AND list_contains($2, unit_id)"
    connection.execute(
        f"DELETE FROM psd_lines WHERE series_id IN (SELECT series_id FROM series {which})", [number, stale]
    )
    for table in _FROM_ARRAYS:
        connection.execute(f"DELETE FROM {table} {which}", [number, stale])


def _name(connection: duckdb.DuckDBPyConnection, number: int, said: Contents) -> None:
    """Bring runs, cases and what their names stand for up to date."""
    own = "(SELECT run_id FROM runs WHERE source = $1)"
    for table in ("run_cases", "case_units", "runs"):
        connection.execute(f"DELETE FROM {table} WHERE run_id IN {own}", [number])
    # A copy of a run directory brings runs that another directory has brought already.
    elsewhere = {row[0] for row in connection.execute("SELECT run_id FROM runs").fetchall()}
    writer = Writer(connection)
    keys = {"cases": "case_id", "unevenness_bands": "unevenness_id"}
    keys |= {table: columns[0] for table, columns in parameters.TABLES.items()}
    for table, rows in said.tables.items():
        if table in keys:
            ids = sorted({row[keys[table]] for row in rows})
            if ids:
                connection.execute(f"DELETE FROM {table} WHERE list_contains($1, {keys[table]})", [ids])
            writer.rows(table, rows)
        else:
            writer.rows(
                table,
                [{**row, "source": number, "sequence": 0} for row in rows if row["run_id"] not in elsewhere],
            )


def _number_runs(connection: duckdb.DuckDBPyConnection) -> None:
    """Give all runs of the file their numbers, in the order in which they started."""
    connection.execute(
        "UPDATE runs SET sequence = ordered.place FROM (SELECT run_id, "
        "row_number() OVER (ORDER BY started NULLS FIRST, run_id) AS place FROM runs) AS ordered "
        "WHERE runs.run_id = ordered.run_id"
    )


def _results(connection: duckdb.DuckDBPyConnection) -> str:
    """Return a digest of what levels and figures depend on; a run that adds nothing leaves it as it is."""
    digest = hashlib.sha256(schema.form_id().encode())
    for query in (
        "SELECT source, unit_id, key FROM ingested",
        "SELECT case_id, approach, source, unit_id FROM current_units",
        "FROM cases",
        "FROM unevenness_bands",
        "SELECT arg_max(reference, sequence) FROM runs",
    ):
        row = connection.execute(
            f"SELECT md5(string_agg(row::VARCHAR, chr(10) ORDER BY row::VARCHAR)) FROM ({query}) AS row"
        ).fetchone()
        digest.update(str(row).encode())
    return digest.hexdigest()


def _failure(record: Row) -> Row:
    lines = str(record.get("traceback", "")).strip().splitlines()
    return {
        **record,
        "error": lines[-1] if lines else "",
        "started": utc(record.get("started")),
        "finished": utc(record.get("finished")),
    }
