"""Narrow-band spectra of the page, line by line while they fit into their share of it.

Beyond it each is thinned to the smallest and the largest line of every bin of frequency, which keeps peaks
and dips where they are, and the page says so.
"""

import math
from dataclasses import dataclass
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries.packing import filled, hundredths, text

LINES_BYTES = 3_000_000
"""Share of the page for narrow-band spectra, before it is written as text."""
_SPECTRA_AT_ONCE = 64
"""Spectra whose lines are read by one query and thinned."""
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
    ends: dict[int, tuple[float, float]] = {}
    spectra_of: dict[int, list[int]] = {}
    for case, spectrum, first, last in connection.execute(
        "SELECT case_number, spectrum, first, last FROM page_series JOIN page_grids USING (case_number) "
        f"WHERE {chosen} ORDER BY ALL"
    ).fetchall():
        spectra_of.setdefault(case, []).append(spectrum)
        ends[case] = first, last
    cases = list(ends)
    if plan.cases < len(cases):
        cases = [cases[round(at)] for at in np.linspace(0, len(cases) - 1, plan.cases)]
    scale = connection.execute(
        "SELECT CASE WHEN quantity = 'wheel_rail_force' THEN 1.0 ELSE 1e18 END AS scale FROM page_receivers "
        "ORDER BY number"
    ).fetchnumpy()["scale"]
    query = (
        "SELECT spectrum, frequency_hz, value FROM psd_lines JOIN page_series USING (series_id) "
        f"WHERE {chosen} AND case_number = $1 AND spectrum BETWEEN $2 AND $3 AND frequency_hz > 0"
    )
    shown = []
    for case in cases:  # few at a time: their lines would take ten times the memory of the page
        ids = np.array(spectra_of[case])
        parts = np.array_split(ids, math.ceil(ids.size / _SPECTRA_AT_ONCE)) if plan.bins else [ids]
        levels = []
        for part in parts:
            found = connection.execute(query, [case, int(part[0]), int(part[-1])]).fetchnumpy()
            row, frequency, value = (filled(found[name]) for name in ("spectrum", "frequency_hz", "value"))
            lines = _Lines(np.searchsorted(part, row), frequency, value * scale[row % sizes.receivers])
            if plan.bins:
                frequency, density = lines.extremes(part.size, plan.bins, *ends[case])
            else:
                frequency, density = lines.all(part.size)
            levels.append(hundredths(_decibels(density)))
        shown.append(
            {
                "case": case,
                "places": (ids // sizes.receivers).tolist(),
                "receivers": (ids % sizes.receivers).tolist(),
                "frequency": [float(f"{each:.6g}") for each in frequency],
                "levels": text(np.concatenate(levels)),
            }
        )
    return shown


@dataclass(frozen=True)
class _Lines:
    """Lines of some spectra in no order: number of the spectrum, frequency, and density or NaN of each."""

    spectrum: NDArray[np.intp]
    frequency: NDArray[np.float64]
    density: NDArray[np.float64]

    def all(self, number: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the frequencies, and the densities of so many spectra."""
        frequency, place = np.unique(self.frequency, return_inverse=True)
        density = np.full((number, frequency.size), np.nan)
        density[self.spectrum, place] = self.density
        return frequency, density

    def extremes(
        self, number: int, bins: int, first: float, last: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the midpoints of bins between two frequencies, and the extreme densities in each."""
        place = bins * np.log(self.frequency / first) / np.log(last / first)
        place = self.spectrum * bins + np.minimum(place, bins - 1).astype(np.intp)
        there = ~np.isnan(self.density)
        ends = np.full((number * bins, 2), (np.inf, -np.inf))
        np.minimum.at(ends[:, 0], place[there], self.density[there])
        np.maximum.at(ends[:, 1], place[there], self.density[there])
        midpoints = first * (last / first) ** ((np.arange(bins) + 0.5) / bins)
        return midpoints, ends.reshape(number, bins, 2)


def _decibels(ratio: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ten times the decimal logarithm, as the database's macro: NaN unless positive and finite."""
    level = np.full(ratio.shape, np.nan)
    return 10.0 * np.log10(ratio, out=level, where=np.isfinite(ratio) & (ratio > 0.0))
