"""Narrow-band spectra of the page, with all lines as long as they fit.

Otherwise each spectrum is thinned to the smallest and the largest line in every bin of frequency, which keeps
peaks and dips in place, and the page says so.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries.database import fetch_columns
from queries.report.packing import hundredths, text
from queries.statements import statements

_SQL = statements("queries.report", "spectra")
LINES_BYTES = 3_000_000
"""Share of the page for narrow-band spectra, before it is written as text."""
_SPECTRA_AT_ONCE = 64
"""Spectra whose lines are read by one query: all of a case would take ten times the page's memory."""
_READ_ALONG = 2
"""Largest gap between wanted spectra that is read and dropped: another query costs more."""
MOST_BINS, FEW_BINS, LEAST_BINS = 1000, 300, 100
"""Bins of a thinned spectrum: at most; below which only dynamic spectra, or fewer cases, are shown."""
FLOOR_DB = 200.0
"""Range of levels below the largest of a receiver, as in the view case_levels; below are rounding errors."""
CONTRIBUTIONS = ("dynamic", "quasi-static", "total")

Data = dict[str, Any]


@dataclass(frozen=True)
class Sizes:
    """Numbers of cases, approaches, receivers and bands of a page."""

    cases: int
    approaches: int
    receivers: int
    bands: int


def spectra(connection: duckdb.DuckDBPyConnection, sizes: Sizes) -> Data:
    """Return narrow-band spectra as levels, with a description of how they were thinned.

    Spectra of one case share their frequencies; there a spectrum is numbered by (approach, contribution,
    receiver).
    """
    query = f"CREATE OR REPLACE TEMP TABLE page_series AS {_SQL['page-series']}"
    connection.execute(query, [len(CONTRIBUTIONS), sizes.receivers])
    connection.execute(f"CREATE OR REPLACE TEMP TABLE page_grids AS {_SQL['page-grids']}")
    row = connection.execute(_SQL["counts"]).fetchone()
    every, dynamic, most_lines, cases = map(int, row or (0, 0, 0, 0))
    thinning = _Thinning.of(every, dynamic, most_lines, cases)
    return asdict(thinning) | {"spectra": _pack(connection, thinning, sizes)}


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


def _pack(connection: duckdb.DuckDBPyConnection, thinning: _Thinning, sizes: Sizes) -> list[Data]:
    """Return the spectra of each shown case: frequencies, and levels of all lines or extremes of bins."""
    columns = fetch_columns(connection, _SQL["series"], [thinning.dynamic_only])
    number, spectrum, series, first, last = columns.values()
    cases, starts = np.unique(number, return_index=True)
    shown = np.arange(cases.size)
    if thinning.cases < cases.size:
        shown = np.array([round(place) for place in np.linspace(0, cases.size - 1, thinning.cases)])
    scale = fetch_columns(connection, _SQL["scales"])["scale"]
    packed = []
    for place in shown:
        rows = slice(starts[place], starts[place + 1] if place + 1 < cases.size else None)
        ids = spectrum[rows]
        receivers = ids % sizes.receivers
        lines = _lines(connection, series[rows])
        if thinning.bins:
            frequency, density = _extremes(lines, ids.size, thinning.bins, first[rows][0], last[rows][0])
        else:
            frequency, density = _all(lines, ids.size)
        approaches = ids // (sizes.receivers * len(CONTRIBUTIONS))
        level = _decibels(density * scale[receivers, None], approaches * sizes.receivers + receivers)
        packed.append(
            {
                "case": int(cases[place]),
                "places": (ids // sizes.receivers).tolist(),
                "receivers": receivers.tolist(),
                "frequency": [float(f"{value:.6g}") for value in frequency],
                "levels": text(hundredths(level)),
            }
        )
    return packed


_Line = tuple[int, NDArray[np.float64], NDArray[np.float64]]
"""Index of a spectrum among those requested, its ascending frequencies above 0, and densities or NaN."""


def _lines(connection: duckdb.DuckDBPyConnection, series: NDArray[Any]) -> Iterator[_Line]:
    """Yield the lines of the spectra that have these numbers in the database."""
    order = np.argsort(series)
    ascending = series[order]
    gaps = np.flatnonzero(np.diff(ascending) > _READ_ALONG + 1) + 1
    for stretch in np.split(np.arange(series.size), gaps):
        for start in range(0, stretch.size, _SPECTRA_AT_ONCE):
            part = stretch[start : start + _SPECTRA_AT_ONCE]
            ends = [int(ascending[part[0]]), int(ascending[part[-1]])]
            row, frequency, density = fetch_columns(connection, _SQL["lines"], ends).values()
            # In order, lines go down in frequency only where the next spectrum begins.
            down = np.flatnonzero(frequency[1:] < frequency[:-1])
            if np.any(row[1:] < row[:-1]) or np.any(row[down] == row[down + 1]):
                place = np.lexsort((frequency, row))  # usually in order, which nothing guarantees
                row, frequency, density = row[place], frequency[place], density[place]
            bounds = np.searchsorted(row, [ascending[part], ascending[part] + 1]).T
            for i, (begin, end) in zip(part, bounds, strict=True):
                above = begin + np.searchsorted(frequency[begin:end], 0.0, side="right")
                yield int(order[i]), frequency[above:end], density[above:end]


def _all(lines: Iterator[_Line], count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the common frequencies of spectra, and the density of each."""
    spectra = list(lines)
    frequency = np.unique(np.concatenate([grid for _, grid, _ in spectra]))
    density = np.full((count, frequency.size), np.nan)
    for place, grid, values in spectra:
        columns = slice(None) if grid.size == frequency.size else np.searchsorted(frequency, grid)
        density[place, columns] = values
    return frequency, density


def _extremes(
    lines: Iterator[_Line], count: int, bins: int, first: float, last: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the midpoints of bins between two frequencies, and the least and largest density in each."""
    density = np.full((count, bins, 2), np.nan)
    grid = np.empty(0)
    for place, frequency, values in lines:
        if not np.array_equal(frequency, grid):
            grid = frequency
            within = bins * np.log(frequency / first) / np.log(last / first)
            filled_bins, starts = np.unique(np.clip(within, 0, bins - 1).astype(np.intp), return_index=True)
        if grid.size:
            density[place, filled_bins, 0] = np.fmin.reduceat(values, starts)
            density[place, filled_bins, 1] = np.fmax.reduceat(values, starts)
    return first * (last / first) ** ((np.arange(bins) + 0.5) / bins), density.reshape(count, 2 * bins)


def _decibels(ratio: NDArray[np.float64], receiver: NDArray[Any]) -> NDArray[np.float64]:
    """Return levels of spectra (spectrum, line); NaN where there is none, as in the database's views.

    There is none where a ratio is not positive or lies below the floor of its receiver, whatever the
    contribution.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        level = 10.0 * np.log10(ratio)
    level[~np.isfinite(level)] = np.nan
    for same in (receiver == value for value in np.unique(receiver)):
        of_receiver = level[same]
        if np.isfinite(of_receiver).any():
            of_receiver[of_receiver < np.nanmax(of_receiver) - FLOOR_DB] = np.nan
            level[same] = of_receiver
    return level
