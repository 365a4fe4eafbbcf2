"""Levels in one-third octaves: wheel-rail force, rail and ground (Figures 6 to 8, 10 and 11)."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import duckdb
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from queries.answers import band
from queries.figures.appearance import Legend, band_axis, label, level_axis, name_panel, page, same_range
from queries.figures.lines import approach_line
from queries.statements import statements

_SQL = statements("queries.figures", "plots")
_VELOCITY = "velocity level [dB re 1e-9 m/s]"
_FORCE = "force level [dB re 1 N]"
_LEVEL = "level [dB re 1e-9 m/s]"
_FREQUENCY = "frequency [Hz]"
_OCTAVES_HZ = (8.0, 16.0, 31.5, 63.0)
"""Octaves that have panels of their own in levels against distance."""


class _Curve(NamedTuple):
    """Bands [Hz], levels [dB], and where unevenness is mostly extrapolated."""

    band: NDArray[np.float64]
    level: NDArray[np.float64]
    extrapolated: NDArray[np.bool_]


_Curves = Mapping[tuple[str, str, str, float | None], _Curve]
"""Curves by case, approach, receiver and offset [m]."""


def force(
    connection: duckdb.DuckDBPyConnection, soil: str, case_id: str, approaches: Sequence[str]
) -> Figure:
    """Draw the wheel-rail force of both axles of the leading bogie."""
    figure, (axes,) = page(1, 2, 2.5)
    legend = Legend()
    names = {"axle-1": "leading axle", "axle-2": "trailing axle"}
    curves = _curves(connection, [case_id], list(names))
    for number, (axis, receiver) in enumerate(zip(axes, names, strict=True)):
        _draw(axis, legend, curves, approaches, (case_id, receiver, None))
        name_panel(axis, number, f"{names[receiver]} of the leading bogie, {soil}")
        label(axis, _FREQUENCY, _FORCE if number == 0 else None)
    same_range(axes)
    legend.show(figure)
    return figure


def rail(
    connection: duckdb.DuckDBPyConnection, cases: Mapping[str, str], approaches: Sequence[str]
) -> Figure:
    """Draw the rail's velocity, a panel per soil; `cases` are ids by soil."""
    width = min(2, len(cases))
    figure, rows = page(math.ceil(len(cases) / width), width, 2.5)
    panels = [axis for row in rows for axis in row]
    curves = _curves(connection, list(cases.values()), ["rail"])
    legend = Legend()
    for number, (soil, case_id) in enumerate(cases.items()):
        _draw(panels[number], legend, curves, approaches, (case_id, "rail", None))
        name_panel(panels[number], number, soil, alone=len(cases) == 1)
        label(panels[number], _FREQUENCY, _VELOCITY if number % width == 0 else None)
    for unused in panels[len(cases) :]:
        unused.set_visible(False)
    same_range(panels[: len(cases)])
    legend.show(figure)
    return figure


def ground(
    connection: duckdb.DuckDBPyConnection,
    cases: Mapping[str, str],
    approaches: Sequence[str],
    offsets: Sequence[float],
) -> Figure:
    """Draw the ground's velocity, a column per soil and a row per offset, all with one range of levels."""
    figure, rows = page(len(offsets), len(cases), 1.75)
    curves = _curves(connection, list(cases.values()), ["ground"])
    legend = Legend()
    for row, offset in enumerate(offsets):
        for column, (soil, case_id) in enumerate(cases.items()):
            axis = rows[row][column]
            _draw(axis, legend, curves, approaches, (case_id, "ground", offset))
            alone = len(cases) * len(offsets) == 1
            name_panel(axis, row * len(cases) + column, f"{offset:g} m, {soil}", alone)
            label(axis, _FREQUENCY if row == len(offsets) - 1 else None, _LEVEL if column == 0 else None)
    same_range([axis for row in rows for axis in row])
    legend.show(figure)
    return figure


def distance(
    connection: duckdb.DuckDBPyConnection, cases: Mapping[str, str], approaches: Sequence[str]
) -> Figure:
    """Draw levels against distance, a column per soil: all bands together, and single octaves."""
    curves = _curves(connection, list(cases.values()), ["ground"])
    bands = sorted({value for curve in curves.values() for value in curve.band.tolist()})
    shown: list[float | None] = [None]
    shown += [value for value in bands if any(abs(value / octave - 1.0) < 0.1 for octave in _OCTAVES_HZ)]
    figure, rows = page(len(shown), len(cases), 1.75)
    legend = Legend()
    for row, band_hz in enumerate(shown):
        for column, (soil, case_id) in enumerate(cases.items()):
            axis = rows[row][column]
            for approach in approaches:
                offsets, levels = _against_distance(curves, case_id, approach, band_hz)
                if offsets.size:
                    legend.curve(axis, offsets, levels, approach_line(approach))
            level_axis(axis)
            title = "all bands" if band_hz is None else f"{band(band_hz)} Hz"
            name_panel(axis, row * len(cases) + column, f"{title}, {soil}")
            last = row == len(shown) - 1
            label(
                axis,
                "distance from the track's centre [m]" if last else None,
                _LEVEL if column == 0 else None,
            )
    same_range([axis for row in rows for axis in row])
    legend.show(figure)
    return figure


def _against_distance(
    curves: _Curves, case_id: str, approach: str, band_hz: float | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return offsets [m], ascending, and levels [dB] there, in one band or of all bands together."""
    levels: dict[float, float] = {}
    for (case, of, _, offset), curve in curves.items():
        if (case, of) == (case_id, approach) and offset is not None:
            within = np.isfinite(curve.level) & ((band_hz is None) | (curve.band == band_hz))
            if within.any():
                levels[offset] = 10.0 * math.log10(float(np.sum(10.0 ** (curve.level[within] / 10.0))))
    offsets = np.array(sorted(levels))
    return offsets, np.array([levels[offset] for offset in offsets.tolist()])


def _curves(
    connection: duckdb.DuckDBPyConnection, case_ids: Sequence[str], receivers: Sequence[str]
) -> _Curves:
    """Return the dynamic levels of receivers in several cases, by one query, as each takes milliseconds."""
    rows = connection.execute(_SQL["levels"], [list(case_ids), list(receivers)]).fetchall()
    return {
        (case_id, approach, receiver, offset): _Curve(
            np.array(bands), np.array(levels, dtype=float), np.array(shares, dtype=float) > 0.5
        )
        for case_id, approach, receiver, offset, bands, levels, shares in rows
    }


def _draw(
    axis: Axes,
    legend: Legend,
    curves: _Curves,
    approaches: Sequence[str],
    place: tuple[str, str, float | None],
) -> None:
    """Draw the levels of a case at a receiver and offset, a line per approach that has results."""
    case_id, receiver, offset = place
    ends: list[float] = []
    for approach in approaches:
        curve = curves.get((case_id, approach, receiver, offset))
        if curve is not None:
            legend.curve(axis, curve.band, curve.level, approach_line(approach), hollow=curve.extrapolated)
            ends += [curve.band[0], curve.band[-1]]
    level_axis(axis)
    if ends:
        band_axis(axis, min(ends), max(ends))
    else:
        text: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 8}
        axis.text(0.5, 0.5, f"no results for {receiver}", transform=axis.transAxes, **text)
