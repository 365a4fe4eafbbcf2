"""How far the approaches are from the reference and what they cost, from the database alone."""

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import duckdb

from queries.answers.table import Table, band, decibels, number
from queries.database.connection import ResultsError

APPROACHES = (
    "moving-roughness",
    "moving-roughness-by-axle",
    "moving-roughness-uncorrelated",
    "full",
    "fe-be",
)
"""In the order in which tables and figures show them; unknown ones follow by name."""

AXES = {"soil": "soil", "track": "track", "train": "train", "unevenness": "unevenness", "speed": "speed_kmh"}
MANY_CASES = 12
"""Above this number of cases tables show what holds over cases, and figures a sample of them."""

_PLACE = """CASE WHEN quantity = 'wheel_rail_force' THEN 'force, all axles'
WHEN receiver = 'ground' THEN 'ground at ' || printf('%g', offset_m) || ' m' ELSE receiver END"""
_PLACE_ORDER = (
    "CASE WHEN quantity = 'wheel_rail_force' THEN -2 WHEN receiver = 'ground' THEN abs(offset_m) ELSE -1 END"
)


_RUNS = """SELECT first.case_id, {columns}, first.level_db AS a_level_db, second.level_db AS b_level_db,
    decibel(first.mean_square / second.mean_square) AS difference_db
FROM {first} AS first JOIN {second} AS second ON {same}
WHERE first.offset_m IS NOT DISTINCT FROM second.offset_m"""
_CASE_NAMES = ("soil", "track", "train", "unevenness", "speed_kmh", "approach")
_NAMES = (*_CASE_NAMES, "contribution", "quantity", "receiver", "averaging", "band_hz")
"""What rows of two runs share; offsets as well, which may be NULL."""


GROUPINGS = {**AXES, "receiver": _PLACE, "band": "band_hz", "approach": "approach"}
HEADINGS = {name: name for name in GROUPINGS} | {"speed": "speed [km/h]", "band": "band [Hz]"}


@dataclass(frozen=True)
class Pair:
    """Two sets of levels, of which one is set against the other.

    Attributes
    ----------
    title
        What is set against what.
    sign
        What is subtracted from what.
    rows
        SQL of rows with the columns of the macro `compare`.
    given
        Values of its parameters.
    """

    title: str
    sign: str
    rows: str
    given: tuple[Any, ...] = ()
    approach: str | None = None

    @staticmethod
    def of_approaches(approach: str, against: str) -> "Pair":
        """Return the pair of two approaches in the newest run of each case."""
        return Pair(
            f"Error of {approach} against {against}",
            f"Level of {approach} minus level of {against}",
            "FROM compare($1, $2)",
            (approach, against),
            approach,
        )

    @staticmethod
    def of_runs(first: "Levels", second: "Levels") -> "Pair":
        """Return the pair of two runs, case by case and approach by approach of the same names."""
        rows = _RUNS.format(
            columns=", ".join(f"first.{name}" for name in (*_NAMES, "offset_m")),
            first=first.relation(1),
            second=second.relation(1 + len(first.given)),
            same=" AND ".join(f"first.{name} = second.{name}" for name in _NAMES),
        )
        return Pair(
            f"{first.title} against {second.title}",
            f"Level of {first.title} minus level of {second.title}, for cases and approaches of the same "
            f"names",
            rows,
            (*first.given, *second.given),
        )

    def kept(self, connection: duckdb.DuckDBPyConnection) -> "Pair":
        """Return the pair with its rows in a table of this connection, for what groups them repeatedly."""
        digest = hashlib.sha256(json.dumps([self.rows, self.given]).encode()).hexdigest()[:16]
        table = f"pair_{digest}"
        there = "SELECT 1 FROM duckdb_tables() WHERE temporary AND table_name = $1"
        if connection.execute(there, [table]).fetchone() is None:  # IF NOT EXISTS would plan the rows first
            connection.execute(f"CREATE TEMP TABLE {table} AS {self.rows}", list(self.given))
        return replace(self, rows=f"FROM {table}", given=())


@dataclass(frozen=True)
class Levels:
    """Levels of one run, or of the newest run of each case where none is named.

    Attributes
    ----------
    title
        What they are called.
    prefix
        Of the database they lie in: nothing, or "other.".
    run_id
        The run.
    """

    title: str
    prefix: str = ""
    run_id: str | None = None

    @property
    def given(self) -> tuple[str, ...]:
        """Values of the parameters of `relation`."""
        return () if self.run_id is None else (self.run_id,)

    def relation(self, number: int, name: str = "levels") -> str:
        """Return the SQL of a view of this run, whose first parameter has this number."""
        if self.run_id is None:
            return f"{self.prefix}{name}"
        return f"(FROM {self.prefix}run_{name} WHERE run_id = ${number})"


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
    return in_order(found)


def in_order(found: Iterable[str]) -> list[str]:
    """Return approaches in the order in which they are shown."""
    found = set(found)
    return [name for name in APPROACHES if name in found] + sorted(found.difference(APPROACHES))


def reference(connection: duckdb.DuckDBPyConnection) -> str:
    """Return the approach that the newest run compares with."""
    row = connection.execute("SELECT reference FROM runs ORDER BY sequence DESC LIMIT 1").fetchone()
    return str(row[0]) if row and row[0] else "full"


def case_count(connection: duckdb.DuckDBPyConnection) -> int:
    """Return the number of cases."""
    row = connection.execute("SELECT count(*) FROM cases").fetchone()
    return int(row[0]) if row else 0


def pairs(connection: duckdb.DuckDBPyConnection) -> list[Pair]:
    """Return every approach with the reference of the study."""
    against = reference(connection)
    return [
        Pair.of_approaches(name, against).kept(connection)
        for name in approaches(connection)
        if name != against
    ]


def varying(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return the axes to name a case by: the soil, and every other axis with more than one value."""
    several = ", ".join(f"min({column}) <> max({column})" for column in AXES.values())
    row = connection.execute(f"SELECT {several} FROM cases").fetchone() or ()
    return [axis for axis, varies in zip(AXES, row, strict=True) if axis == "soil" or varies]


def _constant(connection: duckdb.DuckDBPyConnection) -> str:
    """Return the speed to add to a title where all cases have the same."""
    found = connection.execute("SELECT DISTINCT speed_kmh FROM cases LIMIT 2").fetchall()
    return f", {found[0][0]:g} km/h" if len(found) == 1 else ""


def errors(
    connection: duckdb.DuckDBPyConnection,
    pair: Pair,
    by: Sequence[str] = ("soil", "speed", "receiver"),
    contribution: str = "dynamic",
) -> list[Error]:
    """Return the errors of one set of levels against another, grouped.

    Parameters
    ----------
    connection
        Results of a run.
    pair
        The error is the level of the first minus that of the second, averaged over the line.
    by
        What to group by: soil, track, train, unevenness, speed, receiver, band, and for runs approach.
    contribution
        dynamic, quasi-static or total.

    Raises
    ------
    ResultsError
        If `by` names something else.
    """
    known = GROUPINGS if pair.approach is None else {
        name: column for name, column in GROUPINGS.items() if name != "approach"
    }  # fmt: skip
    for name in by:
        if name not in known:
            raise ResultsError(f"{name}: results cannot be grouped by it, only by {', '.join(known)}")
    # Cases in the order of the study, receivers from the wheel outwards, bands upwards.
    order = {axis: f"min({axis}_place)" for axis in AXES} | {
        "receiver": f"min({_PLACE_ORDER})",
        "band": "band_hz",
        "approach": "approach",
    }
    positions = ", ".join(
        f"min(cases.rowid) OVER (PARTITION BY {column}) AS {axis}_place"
        if axis != "speed"
        else "speed_kmh AS speed_place"
        for axis, column in AXES.items()
    )
    keys = "".join(f"{known[name]} AS key_{number}, " for number, name in enumerate(by))
    grouped = (
        f"GROUP BY {', '.join(f'key_{number}' for number in range(len(by)))}" if by else "HAVING count(*) > 0"
    )
    rows = connection.execute(
        f"WITH positions AS (SELECT case_id, {positions} FROM cases), pair AS ({pair.rows}) "
        f"SELECT {keys} avg(difference_db), avg(abs(difference_db)), "
        "arg_max(difference_db, abs(difference_db)), arg_max(band_hz, abs(difference_db)), count(*) "
        "FROM pair JOIN positions USING (case_id) WHERE averaging = 'line' "
        f"AND contribution = ${len(pair.given) + 1} AND difference_db IS NOT NULL {grouped} "
        + (f"ORDER BY {', '.join(order[name] for name in by)}" if by else ""),
        [*pair.given, contribution],
    ).fetchall()
    return [Error(tuple(row[: len(by)]), *row[len(by) :]) for row in rows]


def error_table(
    connection: duckdb.DuckDBPyConnection,
    pair: Pair,
    by: Sequence[str] | None = None,
    contribution: str = "dynamic",
) -> Table:
    """Return the table of errors of one set of levels against another; `by` defaults to case and receiver."""
    if by is None:
        by = (*([] if pair.approach else ["approach"]), *varying(connection), "receiver")
    found = errors(connection, pair, by, contribution)
    note = f"{pair.sign}, {contribution} contribution, one-third octaves averaged over the line."
    row = connection.execute(
        f"SELECT count(DISTINCT case_id) FROM ({pair.rows}) WHERE averaging = 'line' "
        f"AND contribution = ${len(pair.given) + 1}",
        [*pair.given, contribution],
    ).fetchone()
    there, cases = row[0] if row else 0, case_count(connection)
    if there < cases:
        note += f" Only {there} of {cases} cases have results of both."
    return Table(
        title=pair.title + _constant(connection),
        columns=(*(HEADINGS[name] for name in by), "mean [dB]", "mean |dB|", "largest [dB]", "at [Hz]"),
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


def cost_table_of_runs(connection: duckdb.DuckDBPyConnection, first: Levels, second: Levels) -> Table:
    """Return what two runs cost per approach; times of different kinds of machine are not compared."""
    same = " AND ".join(f"first.{name} = second.{name}" for name in _CASE_NAMES)
    rows = connection.execute(
        "SELECT first.approach, count(*), avg(first.evaluations), avg(second.evaluations), avg(first.cpu_s), "
        "avg(second.cpu_s), CASE WHEN bool_and(coalesce(first.host_class = second.host_class, false)) "
        "THEN avg(second.cpu_s) / avg(first.cpu_s) END "
        f"FROM {first.relation(1, 'runtime')} AS first "
        f"JOIN {second.relation(1 + len(first.given), 'runtime')} AS second ON {same} GROUP BY "
        f"first.approach",
        [*first.given, *second.given],
    ).fetchall()
    by_approach = {row[0]: row for row in rows}
    return Table(
        title=f"Cost per case, {first.title} and {second.title}",
        columns=("approach", "cases", "evaluations", "then", "CPU [s]", "then", "faster"),
        rows=tuple(
            (name, str(cases), number(own, 0), number(then, 0), number(cpu), number(cpu_then), times(ratio))
            for name, cases, own, then, cpu, cpu_then, ratio in map(
                by_approach.__getitem__, in_order(by_approach)
            )
        ),
        words=1,
        note=f"Then: {second.title}. Faster: CPU time of {second.title} over that of {first.title}, only "
        f"where both "
        "ran on one kind of machine.",
    )


def cost_table(connection: duckdb.DuckDBPyConnection, by_case: bool = False) -> Table:
    """Return what each approach costs per case, or over all cases where there are many, unless `by_case`."""
    many = not by_case and case_count(connection) > MANY_CASES
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
        times(faster),
        number(more_cpu),
        times(more_faster),
    ]


def times(ratio: float | None) -> str:
    """Return a ratio of costs as text."""
    return "–" if ratio is None else f"{number(ratio, 2)} ×"


def cell(name: str, value: Any) -> str:
    """Return a value of an axis as text."""
    if value is None:
        return "–"
    if name == "band":
        return band(value)
    return f"{value:g}" if isinstance(value, float) else str(value)
