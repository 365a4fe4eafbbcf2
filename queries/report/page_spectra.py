"""Narrow-band spectra of the page, line by line while they fit into their share of it.

Beyond it each is thinned to the smallest and the largest line of every bin of frequency, which keeps peaks
and dips where they are, and the page says so.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries.report.packing import filled, hundredths, text

LINES_BYTES = 3_000_000
"""Share of the page for narrow-band spectra, before it is written as text."""
_SPECTRA_AT_ONCE = 64
"""Spectra whose lines are read by one query: those of a case would take ten times the memory of the page."""
_READ_ALONG = 2
"""Spectra between two wanted ones that are read and left out: a query costs more."""
MOST_BINS, FEW_BINS, LEAST_BINS = 1000, 300, 100
"""Bins of a thinned spectrum: at most, so few that only dynamic ones are shown, or fewer cases."""
CONTRIBUTIONS = ("dynamic", "quasi-static", "total")

Data = dict[str, Any]


@dataclass(frozen=True)
class Sizes:
    """How many cases, approaches, receivers and bands a page has."""

    cases: int
    approaches: int
    receivers: int
    bands: int


def spectra(connection: duckdb.DuckDBPyConnection, sizes: Sizes) -> Data:
    """Return narrow-band spectra as levels, with what was done to make them fit.

    Spectra of one case share their frequencies; there a spectrum is numbered by (approach, contribution,
    receiver).
    """
    which = (
        "series JOIN current_units USING (source, unit_id, case_id, approach) JOIN page_cases USING "
        "(case_id) "
        "JOIN page_approaches USING (approach) JOIN page_contributions USING (contribution) "
        "JOIN page_receivers ON page_receivers.quantity = series.quantity "
        "AND page_receivers.receiver = series.receiver "
        "AND page_receivers.offset_m IS NOT DISTINCT FROM series.offset_m "
        "WHERE averaging = 'line' AND series.receiver IN ('rail', 'ground', 'axle-1', 'axle-2')"
    )
    connection.execute(
        "CREATE OR REPLACE TEMP TABLE page_series AS SELECT series_id, page_cases.number AS case_number, "
        f"contribution, (page_approaches.number * {len(CONTRIBUTIONS)} + page_contributions.number) "
        f"* {sizes.receivers} + page_receivers.number AS spectrum FROM {which}"
    )
    connection.execute(
        "CREATE OR REPLACE TEMP TABLE page_grids AS SELECT case_number, min(frequency_hz) AS first, "
        "max(frequency_hz) AS last, count(*) AS lines FROM psd_lines "
        "JOIN (SELECT case_number, min(series_id) AS series_id FROM page_series "
        "GROUP BY case_number) USING (series_id) WHERE frequency_hz > 0 GROUP BY case_number"
    )
    row = connection.execute(
        "SELECT (SELECT count(*) FROM page_series), (SELECT count(*) FROM page_series WHERE contribution = "
        "'dynamic'), (SELECT coalesce(max(lines), 0) FROM page_grids), (SELECT count(*) FROM page_grids)"
    ).fetchone()
    every, dynamic, most_lines, cases = map(int, row or (0, 0, 0, 0))
    plan = _Thinning.of(every, dynamic, most_lines, cases)
    return plan.said() | {"spectra": _packed(connection, plan, sizes)}


@dataclass(frozen=True)
class _Thinning:
    """How narrow-band spectra are made to fit: bins (0: every line), contributions, and cases."""

    bins: int
    dynamic_only: bool
    cases: int
    of_cases: int
    lines: int

    @staticmethod
    def of(every: int, dynamic: int, lines: int, cases: int) -> "_Thinning":
        if every * lines * 2 <= LINES_BYTES:
            return _Thinning(0, False, cases, cases, lines)
        bins = LINES_BYTES // (4 * max(every, 1))
        if bins >= FEW_BINS:
            return _Thinning(min(bins, MOST_BINS), False, cases, cases, lines)
        bins = LINES_BYTES // (4 * max(dynamic, 1))
        if bins >= LEAST_BINS:
            return _Thinning(min(bins, MOST_BINS), True, cases, cases, lines)
        shown = max(1, LINES_BYTES * cases // (4 * LEAST_BINS * max(dynamic, 1)))
        return _Thinning(LEAST_BINS, True, shown, cases, lines)

    def said(self) -> Data:
        """Return the plan as the page tells it."""
        return {
            "bins": self.bins,
            "dynamic_only": self.dynamic_only,
            "cases": self.cases,
            "of_cases": self.of_cases,
            "lines": self.lines,
        }


def _packed(connection: duckdb.DuckDBPyConnection, plan: _Thinning, sizes: Sizes) -> list[Data]:
    """Return the spectra of each shown case: frequencies, and levels of all lines or extremes of bins."""
    chosen = "contribution = 'dynamic'" if plan.dynamic_only else "true"
    found = connection.execute(
        "SELECT case_number, spectrum, series_id, first, last FROM page_series JOIN page_grids "
        f"USING (case_number) WHERE {chosen} ORDER BY case_number, spectrum"
    ).fetchnumpy()
    number, spectrum, series, first, last = (np.asarray(column) for column in found.values())
    cases, starts = np.unique(number, return_index=True)
    shown = np.arange(cases.size)
    if plan.cases < cases.size:
        shown = np.array([round(at) for at in np.linspace(0, cases.size - 1, plan.cases)])
    scale = connection.execute(
        "SELECT CASE WHEN quantity = 'wheel_rail_force' THEN 1.0 ELSE 1e18 END AS scale FROM page_receivers "
        "ORDER BY number"
    ).fetchnumpy()["scale"]
    packed = []
    for which in shown:
        rows = slice(starts[which], starts[which + 1] if which + 1 < cases.size else None)
        ids = spectrum[rows]
        receivers = ids % sizes.receivers
        lines = _lines(connection, series[rows])
        if plan.bins:
            frequency, density = _extremes(lines, ids.size, plan.bins, first[rows][0], last[rows][0])
        else:
            frequency, density = _all(lines, ids.size)
        packed.append(
            {
                "case": int(cases[which]),
                "places": (ids // sizes.receivers).tolist(),
                "receivers": receivers.tolist(),
                "frequency": [float(f"{each:.6g}") for each in frequency],
                "levels": text(hundredths(_decibels(density * scale[receivers, None]))),
            }
        )
    return packed


_Line = tuple[int, NDArray[np.float64], NDArray[np.float64]]
"""Place of a spectrum among those asked for, its frequencies above 0 ascending, and densities or NaN."""


def _lines(connection: duckdb.DuckDBPyConnection, series: NDArray[Any]) -> Iterator[_Line]:
    """Yield the lines of the spectra that have these numbers in the database."""
    order = np.argsort(series)
    ascending = series[order]
    far = np.flatnonzero(np.diff(ascending) > _READ_ALONG + 1) + 1
    for stretch in np.split(np.arange(series.size), far):
        for at in range(0, stretch.size, _SPECTRA_AT_ONCE):
            part = stretch[at : at + _SPECTRA_AT_ONCE]
            found = connection.execute(
                "SELECT series_id, frequency_hz, value FROM psd_lines WHERE series_id BETWEEN $1 AND $2",
                [int(ascending[part[0]]), int(ascending[part[-1]])],
            ).fetchnumpy()
            row, frequency, density = (filled(column) for column in found.values())
            # In order, lines go down in frequency only where the next spectrum begins.
            down = np.flatnonzero(frequency[1:] < frequency[:-1])
            if np.any(row[1:] < row[:-1]) or np.any(row[down] == row[down + 1]):
                place = np.lexsort((frequency, row))  # they were written in order, but nobody is bound to
                row, frequency, density = row[place], frequency[place], density[place]
            ends = np.searchsorted(row, [ascending[part], ascending[part] + 1]).T
            for i, (begin, end) in zip(part, ends, strict=True):
                above = begin + np.searchsorted(frequency[begin:end], 0.0, side="right")
                yield int(order[i]), frequency[above:end], density[above:end]


def _all(lines: Iterator[_Line], number: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the frequencies of so many spectra, and the density of each there."""
    held = list(lines)
    frequency = np.unique(np.concatenate([each for _, each, _ in held]))
    density = np.full((number, frequency.size), np.nan)
    for place, own, found in held:
        density[place, slice(None) if own.size == frequency.size else np.searchsorted(frequency, own)] = found
    return frequency, density


def _extremes(
    lines: Iterator[_Line], number: int, bins: int, first: float, last: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the midpoints of bins between two frequencies, and the least and largest density in each."""
    density = np.full((number, bins, 2), np.nan)
    grid = np.empty(0)
    for place, frequency, found in lines:
        if not np.array_equal(frequency, grid):
            grid = frequency
            within = bins * np.log(frequency / first) / np.log(last / first)
            there, starts = np.unique(np.clip(within, 0, bins - 1).astype(np.intp), return_index=True)
        if grid.size:
            density[place, there, 0] = np.fmin.reduceat(found, starts)
            density[place, there, 1] = np.fmax.reduceat(found, starts)
    return first * (last / first) ** ((np.arange(bins) + 0.5) / bins), density.reshape(number, 2 * bins)


def _decibels(ratio: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ten times the decimal logarithm, as the database's macro: NaN unless positive and finite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        level = 10.0 * np.log10(ratio)
    level[~np.isfinite(level)] = np.nan
    return level
