"""Narrow-band spectra of the rail, with the frequencies at which vehicles pass (Figure 9)."""

import math
from collections.abc import Mapping, Sequence

import duckdb
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from queries.database import fetch_columns
from queries.figures.appearance import Legend, band_axis, label, level_axis, name_panel, page
from queries.figures.lines import Line, approach_line
from queries.statements import statements

_SQL = statements("queries.figures", "plots")
_RANGE_DB = 70.0
"""Range of levels that is shown, below the peak."""
_MULTIPLES = 8
"""Number of marked multiples of a passing frequency."""
_MARKS = (("#b9a7c9", "-"), ("#8fb5a8", "--"), ("#d0a88a", ":"))
_KMH = 3.6


def narrow_band(
    connection: duckdb.DuckDBPyConnection,
    cases: Mapping[str, str],
    approaches: Sequence[str],
    speed_kmh: float,
    vehicles: Mapping[float, int],
) -> Figure:
    """Draw narrow-band spectra of the rail's velocity, a panel per soil with one range of levels.

    Parameters
    ----------
    connection
        Results.
    cases
        Their ids by soil.
    approaches
        The one with the finest spectrum first.
    speed_kmh
        Of the train, km/h.
    vehicles
        Number of the train's vehicles by their length in m.
    """
    figure, rows = page(len(cases), 1, 2.3)
    row = connection.execute("SELECT min(band_hz), max(band_hz) FROM bands").fetchone() or (1.0, 100.0)
    lowest, highest = row[0] * 10**-0.05, row[1] * 10**0.05
    series = {
        (case_id, approach): number
        for case_id, approach, number in connection.execute(
            _SQL["rail-series"], [list(cases.values())]
        ).fetchall()
    }
    legend = Legend()
    peak = -math.inf
    for number, (soil, case_id) in enumerate(cases.items()):
        axis = rows[number][0]
        for place, approach in enumerate(approaches):
            data = fetch_columns(connection, _SQL["lines"], [series.get((case_id, approach), -1)])
            frequency, density = data["frequency_hz"], data["value"]
            inside = (frequency >= lowest) & (frequency <= highest) & (density > 0)
            if inside.any():
                level = 10.0 * np.log10(density[inside] * 1e18)
                line = approach_line(approach)
                if place == 0 and len(approaches) > 1:
                    line = _behind(line)
                width = 0.7 if place == 0 else 1.2
                legend.curve(axis, frequency[inside], level, line, markers=False, width=width)
                peak = max(peak, float(level.max()))
        _mark_passing(axis, legend, speed_kmh / _KMH, vehicles, (row[0], row[1]))
        level_axis(axis)
        band_axis(axis, row[0], row[1])
        name_panel(axis, number, soil, alone=len(cases) == 1)
        label(axis, "frequency [Hz]" if number == len(cases) - 1 else None, "density [dB re (1e-9 m/s)²/Hz]")
    if math.isfinite(peak):
        for (axis,) in rows:
            axis.set_ylim(peak - _RANGE_DB, peak + 3.0)
    legend.show(figure)
    return figure


def _behind(line: Line) -> Line:
    """Return a line in its own grey, so that smoother curves stay readable on top."""
    return Line("#8c8c8c" if line.colour == "#000000" else line.colour, (), line.marker, line.label)


def _mark_passing(
    axis: Axes, legend: Legend, speed: float, vehicles: Mapping[float, int], ends: tuple[float, float]
) -> None:
    """Mark the multiples of the frequency at which vehicles of each length follow one another."""
    for (length, count), (colour, dashes) in zip(vehicles.items(), _MARKS, strict=False):
        name = f"multiples of v / {length:g} m, {count} vehicle{'s' if count > 1 else ''}"
        for multiple in range(1, _MULTIPLES + 1):
            frequency = multiple * speed / length
            if ends[0] <= frequency <= ends[1]:
                mark = axis.axvline(frequency, color=colour, linestyle=dashes, linewidth=0.8, zorder=1.5)
                legend.handles.setdefault(name, mark)
