"""Errors of one set of levels against another, over groups of cases, receivers and bands.

Wheel-rail force, rail and ground are never averaged together unless asked for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import duckdb

from queries.answers.approaches import rank
from queries.answers.cases import AXES, HEADINGS, case_count, positions, shared_speed, varying
from queries.answers.comparison import Pair
from queries.answers.table import Table, band, decibels
from queries.database import ResultsError
from queries.statements import statements

_SQL = statements("queries.answers", "errors")
PLACES = {
    "ground": "ground velocity at all offsets",
    "rail": "rail velocity",
    "force": "wheel-rail force of all axles",
    "velocity": "velocity of rail and ground together",
}
"""Places whose results may be averaged, by preference; the last only on request."""
_GROUPINGS = {**AXES, "receiver": _SQL["receiver"], "band": "band_hz", "approach": "approach"}
"""Axes by which errors may be grouped, as SQL."""


@dataclass(frozen=True)
class Error:
    """Error over a group of cases, receivers and bands, dB: the first set of levels minus the second.

    Attributes
    ----------
    group
        Values of the axes of grouping.
    mean, mean_absolute, largest
        Mean, mean size, and the error of the largest size, dB.
    largest_band_hz
        Midband frequency of the largest.
    bands
        Number of bands.
    """

    group: tuple[Any, ...]
    mean: float
    mean_absolute: float
    largest: float
    largest_band_hz: float
    bands: int


def errors(
    connection: duckdb.DuckDBPyConnection,
    pair: Pair,
    by: Sequence[str] = ("soil", "speed", "receiver"),
    contribution: str = "dynamic",
    place: str | None = None,
) -> list[Error]:
    """Return the errors of one set of levels against another, averaged over the line, grouped.

    Parameters
    ----------
    connection
        Results of runs.
    pair
        The pair to compare.
    by
        What to group by: soil, track, train, unevenness, speed, receiver, band, and for runs approach.
    contribution
        dynamic, quasi-static or total.
    place
        Of PLACES, the one whose results count. By default every receiver where `by` tells receivers apart,
        else the one of `usual_place`.

    Raises
    ------
    ResultsError
        If `by` or `place` names something else.
    """
    groupings = {name: sql for name, sql in _GROUPINGS.items() if name != "approach" or pair.approach is None}
    for name in by:
        if name not in groupings:
            raise ResultsError(f"{name}: results cannot be grouped by it, only by {', '.join(groupings)}")
    keys = [f"{groupings[name]} AS key_{number}, " for number, name in enumerate(by)]
    key_names = ", ".join(f"key_{number}" for number in range(len(by)))
    query = _SQL["errors"].format(
        rows=pair.rows,
        keys="".join(keys),
        condition=_condition(place or (None if "receiver" in by else usual_place(connection, pair))),
        group=f"GROUP BY {key_names}" if by else "HAVING count(*) > 0",
    )
    rows = connection.execute(query, {**pair.parameters, "contribution": contribution}).fetchall()
    places = positions(connection)
    rows.sort(
        key=lambda row: [_rank(name, value, row[-1], places) for name, value in zip(by, row, strict=False)]
    )
    return [Error(tuple(row[: len(by)]), *row[len(by) : -1]) for row in rows]


def _rank(name: str, value: Any, distance: float, places: Mapping[str, Mapping[Any, int]]) -> Any:
    """Return the sort key of a value: its position in the study, and receivers from the wheel outwards."""
    if name == "receiver":
        return distance
    if name == "approach":
        return rank(value)
    return value if name == "band" else places[name].get(value, len(places[name]))


def usual_place(connection: duckdb.DuckDBPyConnection, pair: Pair) -> str:
    """Return the default place of a pair: the ground, if it has results."""
    rows = connection.execute(_SQL["places"].format(rows=pair.rows), dict(pair.parameters)).fetchall()
    present = {place for (place,) in rows}
    return next((place for place in PLACES if place in present), "ground")


def _condition(place: str | None) -> str:
    if place is None:
        return "true"
    if place not in PLACES:
        raise ResultsError(f"{place}: no such receivers; there are {', '.join(PLACES)}")
    return "quantity = 'velocity'" if place == "velocity" else f"place(quantity, receiver) = '{place}'"


def error_table(
    connection: duckdb.DuckDBPyConnection,
    pair: Pair,
    by: Sequence[str] | None = None,
    contribution: str = "dynamic",
    place: str | None = None,
) -> Table:
    """Return the table of errors of one set of levels against another.

    Parameters
    ----------
    connection, pair, contribution, place
        As for `errors`.
    by
        What to group by; by default case and receiver. Approaches of two runs always stand apart.
    """
    if by is None:
        by = (*varying(connection), "receiver")
    if pair.approach is None and "approach" not in by:
        by = ("approach", *by)
    if place is None and "receiver" not in by:
        place = usual_place(connection, pair)
    rows = errors(connection, pair, by, contribution, place)
    query = _SQL["compared-cases"].format(rows=pair.rows)
    row = connection.execute(query, {**pair.parameters, "contribution": contribution}).fetchone()
    compared, cases = row[0] if row else 0, case_count(connection)
    note = f"{pair.sign}, {contribution} contribution, one-third octaves averaged over the line."
    if compared < cases:
        note += f" Only {compared} of {cases} cases have results of both."
    speed = shared_speed(connection)
    return Table(
        title=pair.title
        + (f", {speed:g} km/h" if speed is not None else "")
        + f": {PLACES[place] if place else 'every receiver'}, {contribution}",
        columns=(*(HEADINGS[name] for name in by), "mean [dB]", "mean |dB|", "largest [dB]", "at [Hz]"),
        rows=tuple(
            (
                *(cell(name, value) for name, value in zip(by, error.group, strict=True)),
                decibels(error.mean),
                f"{error.mean_absolute:.1f}",
                decibels(error.largest),
                band(error.largest_band_hz),
            )
            for error in rows
        ),
        words=len(by),
        note=note,
    )


def cell(name: str, value: Any) -> str:
    """Return a value of an axis as text."""
    if value is None:
        return "–"
    if name == "band":
        return band(value)
    return f"{value:g}" if isinstance(value, float) else str(value)
