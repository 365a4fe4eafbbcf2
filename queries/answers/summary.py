"""Summary of the results in sentences, from the database alone."""

from collections.abc import Iterable, Sequence

import duckdb

from queries.answers.approaches import label, reference
from queries.answers.cases import case_count, varying
from queries.answers.comparison import Pair, pairs
from queries.answers.costs import times
from queries.answers.errors import Error, cell, errors
from queries.answers.table import Table, band, decibels, number
from queries.statements import statements

_SQL = statements("queries.answers", "summary")
_COSTS = statements("queries.answers", "costs")
TRUSTED_DB = 3.0
"""Mean size of error up to which an approach may stand in for the reference: a factor of two in energy."""
_COLUMNS = {"force": "forces", "rail": "rail", "ground": "ground"}
"""Column headings of places."""
_SENTENCES = 6
"""Largest number of sentences on extrapolated unevenness."""

_Cost = tuple[float | None, float | None, float | None, float | None]
"""CPU seconds of a case, and speed-up over the reference; both again for one more speed."""
_UNKNOWN: _Cost = (None, None, None, None)


def summary(connection: duckdb.DuckDBPyConnection, contribution: str = "dynamic") -> list[str]:
    """Return error and cost of every approach against the reference, in a sentence each."""
    costs = _costs(connection)
    return [
        _sentence(connection, pair, contribution, costs.get(str(pair.approach), _UNKNOWN))
        for pair in pairs(connection)
    ]


def _sentence(connection: duckdb.DuckDBPyConnection, pair: Pair, contribution: str, cost: _Cost) -> str:
    name, against = label(str(pair.approach)), label(reference(connection))
    name = name[:1].upper() + name[1:]
    by_receiver = errors(connection, pair, ("receiver",), contribution)
    if not by_receiver:
        return f"{name} cannot be compared with the {against}: no case has results of both."
    axes = varying(connection)
    by_case = errors(connection, pair, (*axes, "receiver"), contribution)
    best, worst = (choose(by_receiver, key=_mean_size) for choose in (min, max))
    largest = max(by_case, key=lambda error: abs(error.largest))
    where = ", ".join(cell(axis, value) for axis, value in zip(axes, largest.group, strict=False))
    sentence = (
        f"{name} is {worst.mean_absolute:.1f} dB from the {against} on average where it is furthest "
        f"({worst.group[0]}, mean {decibels(worst.mean)} dB), "
        f"{best.mean_absolute:.1f} dB where it is closest ({best.group[0]}); "
        f"the largest difference of a band is {decibels(largest.largest)} dB at "
        f"{band(largest.largest_band_hz)} Hz ({where}, {largest.group[-1]})."
    )
    cpu, faster, marginal_cpu, marginal_faster = cost
    if faster is not None:
        sentence += f" It costs {number(cpu)} CPU seconds per case, {_ratio(faster, against)}"
        if marginal_faster is not None:
            marginal = _ratio(marginal_faster, against)
            sentence += f"; one more speed costs {number(marginal_cpu)} CPU seconds, {marginal}"
        sentence += "."
    return sentence


def _mean_size(error: Error) -> float:
    return error.mean_absolute


def _ratio(factor: float, against: str) -> str:
    if factor >= 1.0:
        return f"{number(factor, 2)} times less than the {against}"
    return f"{number(1.0 / factor, 2)} times more than the {against}"


def _costs(connection: duckdb.DuckDBPyConnection) -> dict[str, _Cost]:
    """Return the cost of a case by each approach, mean over all cases."""
    rows = connection.execute(_COSTS["mean-per-approach"]).fetchall()
    return {approach: (cpu, faster, *marginal) for approach, cpu, faster, *marginal in rows}


def missing_notes(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return one sentence for each approach that lacks results."""
    cases = case_count(connection)
    return [
        f"Missing: {approach} lacks results in {count} of {cases} cases" + (f" ({error})." if error else ".")
        for approach, count, error in connection.execute(_SQL["missing"]).fetchall()
    ]


def extrapolation_notes(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return sentences on bands where over half of the unevenness is extrapolated."""
    rows = connection.execute(_SQL["extrapolated"]).fetchall()
    sentences = []
    for unevenness, speeds, bands, every in rows[:_SENTENCES]:
        at = f"{speeds[0]:g}"
        if len(speeds) > 1:
            at = f"{len(speeds)} speeds from {at} to {speeds[-1]:g}"
        sentences.append(
            f"Extrapolated: more than half of the unevenness {unevenness} lies outside its range of validity "
            f"in {len(bands)} of {len(every)} bands ({_ranges(bands, every)}) at {at} km/h."
        )
    if len(rows) > _SENTENCES:
        more = len(rows) - _SENTENCES
        sentences.append(f"The same holds for {more} more combinations of unevenness, bands and speeds.")
    return sentences


def _ranges(bands: Sequence[float], every: Sequence[float]) -> str:
    """Return bands as text, consecutive ones as a range."""
    places = sorted(every.index(value) for value in bands)
    runs: list[list[int]] = []
    for place in places:
        if runs and place == runs[-1][-1] + 1:
            runs[-1].append(place)
        else:
            runs.append([place])
    names = [[band(every[place]) for place in (run[0], run[-1])] for run in runs]
    return ", ".join(first if first == last else f"{first} to {last}" for first, last in names) + " Hz"


def verdicts(connection: duckdb.DuckDBPyConnection, contribution: str = "dynamic") -> Table:
    """Return error and cost of every approach at a glance, and from which band up it may be trusted."""
    against, costs = label(reference(connection)), _costs(connection)
    rows = []
    for pair in pairs(connection):
        query = _SQL["by-place-and-band"].format(rows=pair.rows)
        errors_by_band = connection.execute(
            query, {**pair.parameters, "contribution": contribution}
        ).fetchall()
        cells = []
        for place in _COLUMNS:
            of_place = [row[1:] for row in errors_by_band if row[0] == place]
            cells += [_mean(of_place), _lowest_trusted_band(of_place)]
        cpu, faster, _, marginal_faster = costs.get(str(pair.approach), _UNKNOWN)
        name = label(str(pair.approach))
        rows.append((name, *cells, number(cpu), times(faster), times(marginal_faster)))
    headings = (
        heading
        for name in _COLUMNS.values()
        for heading in (f"{name}: mean |dB|", f"within {TRUSTED_DB:g} dB from")
    )
    return Table(
        title=f"Against the {against}, at a glance",
        columns=("approach", *headings, "CPU per case [s]", "faster", "faster, one more speed"),
        rows=tuple(rows),
        note=f"Mean size of the error over all cases, receivers and bands. Within {TRUSTED_DB:g} dB from: "
        "the lowest band from which upwards the mean size of the error stays so small. Faster: CPU time of "
        f"the {against} over that of the approach.",
    )


def _mean(rows: Iterable[tuple[float, float, int]]) -> str:
    """Return the mean size of the error over all values, from means and counts of bands."""
    weighted = [(error * count, count) for _, error, count in rows]
    count = sum(number for _, number in weighted)
    return f"{sum(total for total, _ in weighted) / count:.1f}" if count else "–"


def _lowest_trusted_band(rows: Iterable[tuple[float, float, int]]) -> str:
    """Return the lowest band above which all errors are small; rows come from the highest band down."""
    lowest = None
    for band_hz, error, _ in rows:
        if error > TRUSTED_DB:
            break
        lowest = band_hz
    return "–" if lowest is None else f"{band(lowest)} Hz"
