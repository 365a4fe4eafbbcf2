"""How far the approaches are from the reference and what they cost, from the database alone."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import duckdb

from queries.database import ResultsError
from queries.table import Table, band, decibels, number

APPROACHES = (
    "moving-roughness",
    "moving-roughness-by-axle",
    "moving-roughness-uncorrelated",
    "full",
    "fe-be",
)
"""In the order in which tables and figures show them; unknown ones follow by name."""

AXES = {"soil": "soil", "track": "track", "train": "train", "unevenness": "unevenness", "speed": "speed_kmh"}
HEADINGS = {
    "soil": "soil",
    "track": "track",
    "train": "train",
    "unevenness": "unevenness",
    "speed": "speed [km/h]",
}
MANY_CASES = 12
"""Above this number of cases tables show what holds over cases, and figures a sample of them."""

_PLACE = """CASE WHEN quantity = 'wheel_rail_force' THEN 'force, all axles'
WHEN receiver = 'ground' THEN 'ground at ' || printf('%g', offset_m) || ' m' ELSE receiver END"""
_PLACE_ORDER = (
    "CASE WHEN quantity = 'wheel_rail_force' THEN -2 WHEN receiver = 'ground' THEN abs(offset_m) ELSE -1 END"
)


@dataclass(frozen=True)
class Error:
    """Error of an approach over a group of cases, receivers and bands: approach minus reference, dB."""

    group: tuple[Any, ...]
    mean: float
    mean_absolute: float
    largest: float
    largest_band_hz: float
    bands: int


def approaches(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return the approaches that the runs asked for, in the order in which they are shown."""
    found = {row[0] for row in connection.execute("SELECT DISTINCT approach FROM current_units").fetchall()}
    return [name for name in APPROACHES if name in found] + sorted(found.difference(APPROACHES))


def reference(connection: duckdb.DuckDBPyConnection) -> str:
    """Return the approach that the newest run compares with."""
    row = connection.execute("SELECT reference FROM runs ORDER BY sequence DESC LIMIT 1").fetchone()
    return str(row[0]) if row and row[0] else "full"


def case_count(connection: duckdb.DuckDBPyConnection) -> int:
    """Return the number of cases."""
    row = connection.execute("SELECT count(*) FROM cases").fetchone()
    return int(row[0]) if row else 0


def pairs(connection: duckdb.DuckDBPyConnection) -> list[tuple[str, str]]:
    """Return every approach with the reference of the study."""
    against = reference(connection)
    return [(name, against) for name in approaches(connection) if name != against]


def varying(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return the axes to name a case by: the soil, and every other axis with more than one value."""
    counts = ", ".join(f"count(DISTINCT {column})" for column in AXES.values())
    row = connection.execute(f"SELECT {counts} FROM cases").fetchone() or ()
    return [axis for axis, count in zip(AXES, row, strict=True) if axis == "soil" or count > 1]


def _constant(connection: duckdb.DuckDBPyConnection) -> str:
    """Return the speed to add to a title where all cases have the same."""
    found = connection.execute("SELECT DISTINCT speed_kmh FROM cases LIMIT 2").fetchall()
    return f", {found[0][0]:g} km/h" if len(found) == 1 else ""


def errors(
    connection: duckdb.DuckDBPyConnection,
    approach: str,
    against: str,
    by: Sequence[str] = ("soil", "speed", "receiver"),
    contribution: str = "dynamic",
) -> list[Error]:
    """Return the errors of one approach against another, grouped.

    Parameters
    ----------
    connection
        Results of a run.
    approach, against
        The error is the level of `approach` minus that of `against`, averaged over the line.
    by
        What to group by: soil, track, train, unevenness, speed, receiver, band.
    contribution
        dynamic, quasi-static or total.

    Raises
    ------
    ResultsError
        If `by` names something else.
    """
    known = {**AXES, "receiver": _PLACE, "band": "band_hz"}
    for name in by:
        if name not in known:
            raise ResultsError(f"{name}: results cannot be grouped by it, only by {', '.join(known)}")
    # Cases in the order of the study, receivers from the wheel outwards, bands upwards.
    order = {axis: f"min({axis}_place)" for axis in AXES} | {
        "receiver": f"min({_PLACE_ORDER})",
        "band": "band_hz",
    }
    positions = ", ".join(
        f"min(cases.rowid) OVER (PARTITION BY {column}) AS {axis}_place"
        if axis != "speed"
        else "speed_kmh AS speed_place"
        for axis, column in AXES.items()
    )
    keys = "".join(f"{known[name]} AS key_{number}, " for number, name in enumerate(by))
    rows = connection.execute(
        f"WITH positions AS (SELECT case_id, {positions} FROM cases) "
        f"SELECT {keys} avg(difference_db), avg(abs(difference_db)), arg_max(difference_db, "
        "abs(difference_db)), "
        "arg_max(band_hz, abs(difference_db)), count(*) FROM compare($1, $2) JOIN positions USING (case_id) "
        "WHERE averaging = 'line' AND contribution = $3 AND difference_db IS NOT NULL "
        + (
            f"GROUP BY {', '.join(f'key_{number}' for number in range(len(by)))} "
            if by
            else "HAVING count(*) > 0 "
        )
        + (f"ORDER BY {', '.join(order[name] for name in by)}" if by else ""),
        [approach, against, contribution],
    ).fetchall()
    return [Error(tuple(row[: len(by)]), *row[len(by) :]) for row in rows]


def error_table(
    connection: duckdb.DuckDBPyConnection,
    approach: str,
    against: str,
    by: Sequence[str] | None = None,
    contribution: str = "dynamic",
) -> Table:
    """Return the table of errors of one approach against another; `by` defaults to case and receiver."""
    by = tuple(by) if by is not None else (*varying(connection), "receiver")
    found = errors(connection, approach, against, by, contribution)
    constant = _constant(connection)
    headings = {**HEADINGS, "receiver": "receiver", "band": "band [Hz]"}
    note = (
        f"Level of {approach} minus level of {against}, {contribution} contribution, one-third octaves "
        "averaged over the line."
    )
    row = connection.execute(
        "SELECT count(DISTINCT case_id) FROM compare($1, $2) WHERE averaging = 'line' AND contribution = $3",
        [approach, against, contribution],
    ).fetchone()
    there, cases = row[0] if row else 0, case_count(connection)
    if there < cases:
        note += f" Only {there} of {cases} cases have results of both."
    return Table(
        title=f"Error of {approach} against {against}{constant}",
        columns=(
            *(headings[name] for name in by),
            "mean [dB]",
            "mean |dB|",
            "largest [dB]",
            "at [Hz]",
        ),
        rows=tuple(
            (
                *(cell(name, value) for name, value in zip(by, error.group, strict=True)),
                decibels(error.mean),
                f"{error.mean_absolute:.1f}",
                decibels(error.largest),
                band(error.largest_band_hz),
            )
            for error in found
        ),
        words=len(by),
        note=note,
    )


def cost_table(connection: duckdb.DuckDBPyConnection) -> Table:
    """Return what each approach costs per case, or over all cases where there are many."""
    many = case_count(connection) > MANY_CASES
    axes = [] if many else varying(connection)
    keys = "".join(f"{AXES[axis]}, " for axis in axes)
    order = {name: place for place, name in enumerate(approaches(connection))}
    rows = connection.execute(
        f"SELECT {keys} approach, sum(missing_units), avg(evaluations), avg(cpu_s), avg(wall_s), "
        "avg(speed_up), "
        "avg(marginal_speed_cpu_s), avg(marginal_speed_up), min(cases.rowid) AS place "
        "FROM runtime JOIN (SELECT case_id, rowid FROM cases) AS cases USING (case_id) "
        f"GROUP BY {keys} approach ORDER BY place"
    ).fetchall()
    rows.sort(key=lambda row: (0 if many else row[-1], order[row[len(axes)]]))
    incomplete = any(row[len(axes) + 1] for row in rows)
    against = reference(connection)
    return Table(
        title=f"Cost per case{_constant(connection)}" + (", mean over all cases" if many else ""),
        columns=(
            *(HEADINGS[axis] for axis in axes),
            "approach",
            "evaluations",
            "CPU [s]",
            "wall [s]",
            "faster",
            "one more speed [CPU s]",
            "faster",
        ),
        rows=tuple(
            (
                *(cell(axis, value) for axis, value in zip(axes, row, strict=False)),
                row[len(axes)] + (" *" if row[len(axes) + 1] else ""),
                *_cost_cells(row[len(axes) + 2 : -1]),
            )
            for row in rows
        ),
        words=len(axes) + 1,
        note="Work that several approaches share is charged to each in full. "
        f"Faster: CPU time of {against} over that of the approach. "
        "Evaluations: values of a transfer function. Wall time is summed over tasks."
        + (
            " * some work has no recorded cost, because it is missing: the sums are too small."
            if incomplete
            else ""
        ),
    )


def _cost_cells(values: Iterable[Any]) -> list[str]:
    evaluations, cpu, wall, faster, more_cpu, more_faster = values
    return [
        number(evaluations, 0),
        number(cpu),
        number(wall),
        _times(faster),
        number(more_cpu),
        _times(more_faster),
    ]


def _times(ratio: float | None) -> str:
    return "–" if ratio is None else f"{number(ratio, 2)} ×"


def cell(name: str, value: Any) -> str:
    """Return a value of an axis as text."""
    if value is None:
        return "–"
    if name == "band":
        return band(value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def tables(connection: duckdb.DuckDBPyConnection, contribution: str = "dynamic") -> list[Table]:
    """Return the tables that end a run: errors of each approach against the reference, and costs."""
    by = ("receiver",) if case_count(connection) > MANY_CASES else None
    found = [
        error_table(connection, approach, against, by, contribution)
        for approach, against in pairs(connection)
    ]
    return [*found, cost_table(connection)]
