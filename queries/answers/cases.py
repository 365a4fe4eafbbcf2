"""The cases of the results, by the names that studies give them."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import duckdb

AXES = {"soil": "soil", "track": "track", "train": "train", "unevenness": "unevenness", "speed": "speed_kmh"}
"""Axes of a study with their columns."""
HEADINGS = {name: name for name in (*AXES, "receiver", "approach")} | {
    "speed": "speed [km/h]",
    "band": "band [Hz]",
}
"""Headings of columns of tables."""
MANY_CASES = 12
"""Number of cases above which tables summarise them, and figures show a sample."""


class NamedCase(NamedTuple):
    """A case under one of its names; `train_id` identifies the definition of its train."""

    case_id: str
    soil: str
    track: str
    train: str
    unevenness: str
    speed_kmh: float
    train_id: str | None


def named_cases(connection: duckdb.DuckDBPyConnection) -> list[NamedCase]:
    """Return one case per combination of names, the newest, in the order of the study."""
    columns = ", ".join(NamedCase._fields)
    rows = connection.execute(f"SELECT {columns} FROM named_cases ORDER BY place").fetchall()
    return [NamedCase(*row) for row in rows]


def case_count(connection: duckdb.DuckDBPyConnection) -> int:
    """Return the number of cases; a case with two names counts twice."""
    row = connection.execute("SELECT count(*) FROM cases").fetchone()
    return int(row[0]) if row else 0


def varying(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return the axes to name a case by: the soil, and every other axis with more than one value."""
    several = ", ".join(f"min({column}) <> max({column})" for column in AXES.values())
    row = connection.execute(f"SELECT {several} FROM cases").fetchone() or ()
    return [axis for axis, varies in zip(AXES, row, strict=True) if axis == "soil" or varies]


def shared_speed(connection: duckdb.DuckDBPyConnection) -> float | None:
    """Return the speed of all cases, km/h, or None if they have several."""
    rows = connection.execute("SELECT DISTINCT speed_kmh FROM cases LIMIT 2").fetchall()
    return float(rows[0][0]) if len(rows) == 1 else None


def positions(connection: duckdb.DuckDBPyConnection) -> Mapping[str, Mapping[Any, int]]:
    """Return the position of every value of an axis: in study order, speeds ascending."""
    rows = connection.execute(f"SELECT {', '.join(AXES.values())} FROM cases ORDER BY rowid").fetchall()
    columns = list(zip(*rows, strict=True)) or [()] * len(AXES)
    values = {axis: list(dict.fromkeys(column)) for axis, column in zip(AXES, columns, strict=True)}
    values["speed"].sort()
    return {
        axis: {value: place for place, value in enumerate(axis_values)}
        for axis, axis_values in values.items()
    }
