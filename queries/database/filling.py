"""Bring the rows of one run directory up to date; rows that are present are kept, as they cannot change."""

import hashlib

import duckdb

from queries.database import arrays, definitions, manifests, schema
from queries.database.manifests import Contents, Row, utc
from queries.database.rows import Writer
from queries.database.sources import Source
from queries.statements import statements
from sweep.storage import records

_SQL = statements("queries.database", "filling")

_FROM_ARRAYS = ("bands", "passage_levels", "receptances", "series", "ingested")
"""Tables filled from the store, unit by unit; psd_lines follows series."""
_FROM_RECORDS = ("units", "unit_costs", "failures")
_OF_RUNS = ("run_cases", "case_units", "runs")
_MEMORY = "64MB"
"""Memory limit of DuckDB while rows of arrays are inserted, whose number is unbounded."""


def fill(connection: duckdb.DuckDBPyConnection, source: Source) -> list[str]:
    """Bring the rows of one run directory up to date; return its units whose arrays cannot be read."""
    contents = manifests.contents(source.manifests)
    number = _number(connection, source)
    for table in _FROM_RECORDS:
        connection.execute(f"DELETE FROM {table} WHERE source = ?", [number])
    _drop_stale(connection, number, source, contents)
    _replace_descriptions(connection, number, contents)
    writer = Writer(connection)
    reader = arrays.Reader(writer, source.directory, number, contents)
    query = "SELECT unit_id FROM ingested WHERE source = ?"
    ingested = {row[0] for row in connection.execute(query, [number]).fetchall()}
    failures = [_failure(record) for record in source.failures]
    units: list[Row] = []
    costs: list[Row] = []
    keys: list[Row] = []
    unreadable: list[str] = []
    connection.execute(f"SET memory_limit = '{_MEMORY}'")
    for record in records.commits(source.directory):
        unit = record["unit_id"]
        if record["kind"] in arrays.INSERTS and unit in contents.owners and unit not in ingested:
            fault = reader.read(record)
            if fault is not None:
                failures.append(_failure({**record, "traceback": fault}))
                unreadable.append(unit)
                continue
            keys.append({"unit_id": unit, "key": contents.key(unit)})
        units.append(_with_times(record))
        costs += [{**record, **cost} for cost in record.get("costs", [])]
    writer.flush()
    connection.execute("RESET memory_limit")
    tables = (("ingested", keys), ("units", units), ("unit_costs", costs), ("failures", failures))
    for table, rows in tables:
        writer.rows(table, [{**row, "source": number} for row in rows])
    return unreadable


def finish(connection: duckdb.DuckDBPyConnection) -> None:
    """Assign numbers to all runs, and store a digest of all that results depend on."""
    connection.execute(_SQL["number-runs"])
    connection.execute("DELETE FROM snapshot")
    connection.execute("INSERT INTO snapshot VALUES (?)", [_results(connection)])


def _number(connection: duckdb.DuckDBPyConnection, source: Source) -> int:
    """Return the number of a run directory in the file; assign one if it has none."""
    row = connection.execute("SELECT source FROM sources WHERE directory = ?", [source.name]).fetchone()
    if row is None:
        row = connection.execute("SELECT coalesce(max(source), 0) + 1 FROM sources").fetchone()
        assert row is not None
        connection.execute("INSERT INTO sources VALUES (?, ?, NULL)", [row[0], source.name])
    connection.execute("UPDATE sources SET fingerprint = ? WHERE source = ?", [source.fingerprint, row[0]])
    return int(row[0])


def _drop_stale(
    connection: duckdb.DuckDBPyConnection, number: int, source: Source, contents: Contents
) -> None:
    """Drop rows of arrays whose units are gone, or now serve other cases."""
    rows = connection.execute("SELECT unit_id, key FROM ingested WHERE source = ?", [number]).fetchall()
    stale = [
        unit
        for unit, key in rows
        if unit not in source.present or unit not in contents.owners or contents.key(unit) != key
    ]
    if stale:
        connection.execute(_SQL["drop-lines"], [number, stale])
        for table in _FROM_ARRAYS:
            condition = "source = $1 AND list_contains($2, unit_id)"
            connection.execute(f"DELETE FROM {table} WHERE {condition}", [number, stale])


def _replace_descriptions(connection: duckdb.DuckDBPyConnection, number: int, contents: Contents) -> None:
    """Bring runs, cases and definitions up to date."""
    for table in _OF_RUNS:
        runs = "SELECT run_id FROM runs WHERE source = $1"
        connection.execute(f"DELETE FROM {table} WHERE run_id IN ({runs})", [number])
    # Runs of a copied directory may be in the database already.
    elsewhere = {row[0] for row in connection.execute("SELECT run_id FROM runs").fetchall()}
    writer = Writer(connection)
    keys = {"cases": manifests.LABEL, "unevenness_bands": ("unevenness_id",)}
    keys |= {table: columns[:1] for table, columns in definitions.TABLES.items()}
    for table, rows in contents.tables.items():
        if table in keys:
            writer.rows(table, rows, replacing=keys[table])
        else:
            fresh = [row for row in rows if row["run_id"] not in elsewhere]
            writer.rows(table, [{**row, "source": number, "sequence": 0} for row in fresh])


def _results(connection: duckdb.DuckDBPyConnection) -> str:
    """Return a digest of all that levels and figures depend on; runs that add nothing keep it."""
    digest = hashlib.sha256(schema.form_id().encode())
    for query in (
        "SELECT source, unit_id, key FROM ingested",
        "SELECT case_id, approach, source, unit_id FROM current_units",
        "FROM cases",
        "FROM unevenness_bands",
        "SELECT arg_max(reference, sequence) FROM runs",
    ):
        row = connection.execute(_SQL["digest"].format(query=query)).fetchone()
        digest.update(str(row).encode())
    return digest.hexdigest()


def _failure(record: Row) -> Row:
    lines = str(record.get("traceback", "")).strip().splitlines()
    return {**_with_times(record), "error": lines[-1] if lines else ""}


def _with_times(record: Row) -> Row:
    return {**record, **{name: utc(record.get(name)) for name in ("started", "finished")}}
