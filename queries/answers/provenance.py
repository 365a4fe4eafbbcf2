"""Where results come from: runs, hosts, versions, plans, and what the names of a study stand for."""

import json
from typing import Any

import duckdb

from queries.answers.table import Table, number


def tables(connection: duckdb.DuckDBPyConnection) -> list[Table]:
    """Return the runs that results come from, what they took, and what their names stand for."""
    return [
        _runs(connection),
        _measured(connection),
        _rows(connection),
        _soils(connection),
        _failures(connection),
    ]


def _runs(connection: duckdb.DuckDBPyConnection) -> Table:
    rows = connection.execute(
        "SELECT run_id, study, started, finished, exit_status, host, host_class, threads, model_version, "
        "versions "
        "FROM runs ORDER BY sequence"
    ).fetchall()
    return Table(
        "Runs",
        (
            "run",
            "study",
            "started (UTC)",
            "finished (UTC)",
            "exit",
            "host",
            "kind of host",
            "threads",
            "model",
            "versions",
        ),  # fmt: skip
        tuple(
            (
                *("–" if value is None else str(value) for value in row[:-1]),
                ", ".join(f"{name} {version}" for name, version in _pairs(row[-1])),
            )
            for row in rows
        ),
        words=10,
    )


def _pairs(text: str | None) -> list[tuple[str, Any]]:
    return list((json.loads(text or "null") or {}).items())


def _measured(connection: duckdb.DuckDBPyConnection) -> Table:
    rows = connection.execute(
        "SELECT run_id, measured_tasks, planned_cpu_s, measured_cpu_s, measured_wall_s, planned_bytes / 1e6, "
        "measured_bytes / 1e6, planned_peak_memory_bytes / 1e6, measured_peak_memory_bytes / 1e6 "
        "FROM runs ORDER BY sequence"
    ).fetchall()
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
        ),  # fmt: skip
        tuple((str(row[0]), *(number(value) for value in row[1:])) for row in rows),
        note="Memory: of the largest worker process. A dash: the run did not say.",
    )


def _rows(connection: duckdb.DuckDBPyConnection) -> Table:
    counts = connection.execute(
        "SELECT (SELECT count(*) FROM cases), (SELECT count(*) FROM bands), (SELECT count(*) FROM "
        "psd_lines), "
        "(SELECT count(*) FROM failures)"
    ).fetchone()
    return Table(
        "Rows of the database",
        ("cases", "one-third octaves", "narrow-band lines", "failures"),
        (tuple(f"{count:,}" for count in counts or ()),),
        words=0,
    )


def _soils(connection: duckdb.DuckDBPyConnection) -> Table:
    rows = connection.execute(
        "SELECT soil, layer, thickness_m, shear_speed_m_s, dilatational_speed_m_s, rayleigh_speed_m_s, "
        "density_kg_m3, loss_factor FROM soil_layers ORDER BY soil, soil_id, layer"
    ).fetchall()
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
        ),  # fmt: skip
        tuple(
            (
                str(soil),
                str(layer),
                "half-space" if thickness is None else number(thickness),
                *map(number, values),
            )
            for soil, layer, thickness, *values in rows
        ),
    )


def _failures(connection: duckdb.DuckDBPyConnection) -> Table:
    rows = connection.execute(
        "SELECT kind, unit_id, attempt, worker, error FROM failures ORDER BY kind, unit_id"
    ).fetchall()
    return Table(
        "Failures",
        ("kind", "unit", "attempt", "worker", "error"),
        tuple(tuple("–" if value is None else str(value) for value in row) for row in rows),
        words=5,
    )
