"""What each approach costs, from the database alone."""

from collections.abc import Iterable
from typing import Any

import duckdb

from queries.answers.approaches import in_order, rank, reference
from queries.answers.cases import AXES, HEADINGS, MANY_CASES, case_count, positions, shared_speed, varying
from queries.answers.comparison import CASE_NAMES, Levels
from queries.answers.errors import cell
from queries.answers.table import Table, number
from queries.statements import statements

_SQL = statements("queries.answers", "costs")


def cost_table(connection: duckdb.DuckDBPyConnection, by_case: bool = False) -> Table:
    """Return the cost of each approach: per case if `by_case` or few, otherwise the mean over cases."""
    many = not by_case and case_count(connection) > MANY_CASES
    axes = [] if many else varying(connection)
    query = _SQL["per-case"].format(keys="".join(f"{AXES[axis]}, " for axis in axes))
    rows = connection.execute(query).fetchall()
    places = positions(connection)
    rows.sort(
        key=lambda row: (
            [places[axis][value] for axis, value in zip(axes, row, strict=False)],
            rank(row[len(axes)]),
        )
    )
    incomplete = any(row[len(axes) + 1] for row in rows)
    note = (
        "Work that several approaches share is charged to each in full. "
        f"Faster: CPU time of {reference(connection)} over that of the approach. "
        "Evaluations: values of a transfer function. Wall time is summed over tasks."
    )
    if incomplete:
        note += " * some work has no recorded cost, because it is missing: the sums are too small."
    speed = shared_speed(connection)
    return Table(
        title="Cost per case"
        + (f", {speed:g} km/h" if speed is not None else "")
        + (", mean over all cases" if many else ""),
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
                *_cells(row[len(axes) + 2 :]),
            )
            for row in rows
        ),
        words=len(axes) + 1,
        note=note,
    )


def _cells(values: Iterable[Any]) -> list[str]:
    evaluations, cpu, wall, faster, marginal_cpu, marginal_faster = values
    return [
        number(evaluations, 0),
        number(cpu),
        number(wall),
        times(faster),
        number(marginal_cpu),
        times(marginal_faster),
    ]


def cost_table_of_runs(connection: duckdb.DuckDBPyConnection, first: Levels, second: Levels) -> Table:
    """Return the costs of two runs per approach; times are compared on one kind of machine only."""
    query = _SQL["two-runs"].format(
        first=first.relation("runtime"),
        second=second.relation("runtime"),
        same=" AND ".join(f"first.{name} = second.{name}" for name in CASE_NAMES),
    )
    rows = connection.execute(query, {**first.parameters, **second.parameters}).fetchall()
    by_approach = {row[0]: row[1:] for row in rows}
    return Table(
        title=f"Cost per case, {first.title} and {second.title}",
        columns=("approach", "cases", "evaluations", "then", "CPU [s]", "then", "faster"),
        rows=tuple(
            (
                name,
                str(cases),
                number(evaluations, 0),
                number(evaluations_then, 0),
                number(cpu),
                number(cpu_then),
                times(ratio),
            )
            for name in in_order(by_approach)
            for cases, evaluations, evaluations_then, cpu, cpu_then, ratio in (by_approach[name],)
        ),
        words=1,
        note=f"Then: {second.title}. Faster: CPU time of {second.title} over that of {first.title}, only "
        "where both ran on one kind of machine.",
    )


def times(ratio: float | None) -> str:
    """Return a ratio of costs as text."""
    return "–" if ratio is None else f"{number(ratio, 2)} ×"
