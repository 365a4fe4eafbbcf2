"""Provenance of results: runs, hosts, versions, plans, and definitions of the study's names."""

import json
from typing import Any

import duckdb

from queries.answers.table import Table, number
from queries.statements import statements

_SQL = statements("queries.answers", "provenance")


def tables(connection: duckdb.DuckDBPyConnection) -> list[Table]:
    """Return tables of runs, their costs, row counts, soils and failures."""
    return [table(connection) for table in (_runs, _planned_and_measured, _row_counts, _soils, _failures)]


def _runs(connection: duckdb.DuckDBPyConnection) -> Table:
    columns = ("run", "study", "started (UTC)", "finished (UTC)", "exit", "host", "kind of host", "threads")
    rows = []
    for *values, versions in connection.execute(_SQL["runs"]).fetchall():
        libraries = (json.loads(versions or "null") or {}).items()
        rows.append((*map(_text, values), ", ".join(f"{name} {version}" for name, version in libraries)))
    return Table("Runs", (*columns, "model", "versions"), tuple(rows), words=10)


def _planned_and_measured(connection: duckdb.DuckDBPyConnection) -> Table:
    return Table(
        "Planned and measured",
        (
            "run",
            "tasks",
            "CPU planned [s]",
            "CPU [s]",
            "wall [s]",
            "store planned [MB]",
            "store [MB]",
            "memory planned [MB]",
            "memory [MB]",
        ),
        tuple(
            (str(run), *map(number, values))
            for run, *values in connection.execute(_SQL["measured"]).fetchall()
        ),
        note="Memory: of the largest worker process. A dash: the run did not say.",
    )


def _row_counts(connection: duckdb.DuckDBPyConnection) -> Table:
    counts = connection.execute(_SQL["row-counts"]).fetchone() or ()
    columns = ("cases", "one-third octaves", "narrow-band lines", "failures")
    return Table("Rows of the database", columns, (tuple(f"{count:,}" for count in counts),), words=0)


def _soils(connection: duckdb.DuckDBPyConnection) -> Table:
    return Table(
        "Soils",
        (
            "soil",
            "layer",
            "thickness [m]",
            "shear speed [m/s]",
            "dilatational speed [m/s]",
            "Rayleigh speed [m/s]",
            "density [kg/m³]",
            "loss factor",
        ),
        tuple(
            (
                str(soil),
                str(layer),
                "half-space" if thickness is None else number(thickness),
                *map(number, values),
            )
            for soil, layer, thickness, *values in connection.execute(_SQL["soils"]).fetchall()
        ),
    )


def _failures(connection: duckdb.DuckDBPyConnection) -> Table:
    rows = connection.execute(_SQL["failures"]).fetchall()
    columns = ("kind", "unit", "attempt", "worker", "error")
    return Table("Failures", columns, tuple(tuple(map(_text, row)) for row in rows), words=5)


def _text(value: Any) -> str:
    return "–" if value is None else str(value)
