"""What the results say, in sentences made from the database alone."""

import duckdb

from queries.answers.compare import Error, case_count, cell, errors, pairs, reference, times, varying
from queries.answers.table import Table, band, decibels, number
from queries.figures.lines import approach_line

TRUSTED_DB = 3.0
"""Mean size of error up to which an approach may stand in for the reference: a factor of two in energy."""

PLACES = {
    "forces": "quantity = 'wheel_rail_force'",
    "rail": "receiver = 'rail'",
    "ground": "receiver = 'ground'",
}
"""What errors are summed up over, by their condition in SQL."""


def summary(connection: duckdb.DuckDBPyConnection, contribution: str = "dynamic") -> list[str]:
    """Return what the data say, in sentences: error and cost of every approach, and what is missing."""
    sentences = []
    against, spent = reference(connection), _spent(connection)
    for pair in pairs(connection):
        approach = str(pair.approach)
        places = errors(connection, pair, ("receiver",), contribution)
        whole = errors(connection, pair, (*varying(connection), "receiver"), contribution)
        name, other = _label(approach), approach_line(against).label
        if not places:
            sentences.append(f"{name} cannot be compared with the {other}: no case has results of both.")
            continue
        best, worst = min(places, key=_size), max(places, key=_size)
        largest = max(whole, key=lambda error: abs(error.largest))
        where = ", ".join(
            cell(axis, value) for axis, value in zip(varying(connection), largest.group, strict=False)
        )
        sentence = (
            f"{name} is {worst.mean_absolute:.1f} dB from the {other} on average where it is furthest "
            f"({worst.group[0]}, mean {decibels(worst.mean)} dB), "
            f"{best.mean_absolute:.1f} dB where it is closest ({best.group[0]}); "
            f"the largest difference of a band is {decibels(largest.largest)} dB at "
            f"{band(largest.largest_band_hz)} Hz ({where}, {largest.group[-1]})."
        )
        cpu, faster, more, more_faster = spent.get(approach, _NOTHING)
        if faster is not None:
            sentence += f" It costs {number(cpu)} CPU seconds per case, {_ratio(faster, other)}"
            if more_faster is not None:
                sentence += f"; one more speed costs {number(more)} CPU seconds, {_ratio(more_faster, other)}"
            sentence += "."
        sentences.append(sentence)
    return sentences


_Spent = tuple[float | None, float | None, float | None, float | None]
"""CPU seconds of a case and how much faster that is than the reference; the same of one more speed."""
_NOTHING: _Spent = (None, None, None, None)


def _spent(connection: duckdb.DuckDBPyConnection) -> dict[str, _Spent]:
    """Return what a case takes by each approach, mean over all cases."""
    rows = connection.execute(
        "SELECT approach, avg(cpu_s), avg(speed_up), avg(marginal_speed_cpu_s), avg(marginal_speed_up) "
        "FROM runtime GROUP BY approach"
    ).fetchall()
    return {approach: (cpu, faster, more, more_faster) for approach, cpu, faster, more, more_faster in rows}


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


def _label(approach: str) -> str:
    label = approach_line(approach).label
    return label[:1].upper() + label[1:]


def _size(error: Error) -> float:
    return error.mean_absolute


def _ratio(times: float, against: str) -> str:
    if times >= 1.0:
        return f"{number(times, 2)} times less than the {against}"
    return f"{number(1.0 / times, 2)} times more than the {against}"


def verdicts(connection: duckdb.DuckDBPyConnection, contribution: str = "dynamic") -> Table:
    """Return error and cost of every approach at a glance, and from which band up it may be trusted."""
    against, spent = reference(connection), _spent(connection)
    places = " ".join(f"WHEN {condition} THEN '{place}'" for place, condition in PLACES.items())
    rows = []
    for pair in pairs(connection):
        found = connection.execute(
            f"SELECT CASE {places} END AS place, band_hz, avg(abs(difference_db)), count(*) "
            f"FROM ({pair.rows}) WHERE averaging = 'line' AND contribution = ${len(pair.given) + 1} "
            "AND difference_db IS NOT NULL GROUP BY place, band_hz ORDER BY band_hz DESC",
            [*pair.given, contribution],
        ).fetchall()
        cells = []
        for place in PLACES:
            there = [row[1:] for row in found if row[0] == place]
            cells += [_mean(there), _trusted(there)]
        cpu, faster, _, more_faster = spent.get(str(pair.approach), _NOTHING)
        label = approach_line(str(pair.approach)).label
        rows.append((label, *cells, number(cpu), times(faster), times(more_faster)))
    return Table(
        title=f"Against the {approach_line(against).label}, at a glance",
        columns=(
            "approach",
            *(head for place in PLACES for head in (f"{place}: mean |dB|", f"within {TRUSTED_DB:g} dB from")),
            "CPU per case [s]",
            "faster",
            "faster, one more speed",
        ),
        rows=tuple(rows),
        note=f"Mean size of the error over all cases, receivers and bands. Within {TRUSTED_DB:g} dB from: "
        f"the lowest "
        "band from which upwards the mean size of the error stays so small. Faster: CPU time of "
        f"the {approach_line(against).label} over that of the approach.",
    )


def _mean(found: list[tuple[float, float, int]]) -> str:
    count = sum(row[2] for row in found)
    return f"{sum(row[1] * row[2] for row in found) / count:.1f}" if count else "–"


def _trusted(found: list[tuple[float, float, int]]) -> str:
    """Return the lowest band from which upwards the error is small, given from the highest band down."""
    lowest = None
    for band_hz, error, _ in found:
        if error > TRUSTED_DB:
            break
        lowest = band_hz
    return "–" if lowest is None else f"{band(lowest)} Hz"
