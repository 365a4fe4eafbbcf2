"""What the results say, in sentences made from the database alone."""

import duckdb

from queries.compare import (
    MANY_CASES,
    Error,
    case_count,
    cell,
    cost_table,
    error_table,
    errors,
    pairs,
    reference,
    varying,
)
from queries.table import Table, band, decibels, number


def summary(connection: duckdb.DuckDBPyConnection, contribution: str = "dynamic") -> list[str]:
    """Return what the data say, in sentences: error and cost of every approach, and what is missing."""
    sentences = []
    against = reference(connection)
    for pair in pairs(connection):
        approach = pair.approach
        places = errors(connection, pair, ("receiver",), contribution)
        whole = errors(connection, pair, (*varying(connection), "receiver"), contribution)
        if not places:
            sentences.append(f"{approach} cannot be compared with {against}: no case has results of both.")
            continue
        best, worst = min(places, key=_size), max(places, key=_size)
        largest = max(whole, key=lambda error: abs(error.largest))
        where = ", ".join(
            cell(name, value) for name, value in zip(varying(connection), largest.group, strict=False)
        )
        sentences.append(
            f"{approach} differs from {against} by {worst.mean_absolute:.1f} dB on average at the worst "
            "receiver "
            f"({worst.group[0]}, mean {decibels(worst.mean)} dB) and by {best.mean_absolute:.1f} dB at the "
            "best "
            f"({best.group[0]}, mean {decibels(best.mean)} dB); the largest difference of a band is "
            f"{decibels(largest.largest)} dB at {band(largest.largest_band_hz)} Hz ({where}, "
            f"{largest.group[-1]})."
        )
        row = connection.execute(
            "SELECT avg(cpu_s), avg(speed_up), avg(marginal_speed_cpu_s), avg(marginal_speed_up) FROM "
            "runtime WHERE approach = ?",
            [approach],
        ).fetchone()
        if row and row[1] is not None:
            sentence = f"{approach} costs {number(row[0])} CPU seconds per case, {_ratio(row[1], against)}"
            if row[3] is not None:
                sentence += f"; one more speed costs {number(row[2])} CPU seconds, {_ratio(row[3], against)}"
            sentences.append(sentence + ".")
    return sentences + missing(connection)


def missing(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return what was asked for and is not there, in sentences."""
    lost = connection.execute(
        "SELECT approach, count(DISTINCT case_id), any_value(error) FROM missing GROUP BY approach ORDER BY "
        "approach"
    ).fetchall()
    cases = case_count(connection)
    return [
        f"Missing: {approach} lacks results in {count} of {cases} cases" + (f" ({error})." if error else ".")
        for approach, count, error in lost
    ]


def _size(error: Error) -> float:
    return error.mean_absolute


def _ratio(times: float, against: str) -> str:
    if times >= 1.0:
        return f"{number(times, 2)} times less than {against}"
    return f"{number(1.0 / times, 2)} times more than {against}"


def tables(connection: duckdb.DuckDBPyConnection, contribution: str = "dynamic") -> list[Table]:
    """Return the tables of a report: errors of each approach against the reference, and costs."""
    by = ("receiver",) if case_count(connection) > MANY_CASES else None
    found = [error_table(connection, pair, by, contribution) for pair in pairs(connection)]
    return [*found, cost_table(connection)]
