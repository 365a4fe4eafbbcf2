"""Figures of what approaches are worth: level against distance, error over speed and band, and cost."""

import math
from collections.abc import Sequence
from typing import Any

import duckdb
import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from queries.answers.combination import Combination
from queries.answers.table import band
from queries.figures.appearance import label, legend, level_axis, name_panel, page
from queries.figures.lines import approach_line
from queries.figures.plots import Legend

_SHOWN_BANDS_HZ = (8.0, 16.0, 31.5, 63.0)
_MOST_DB = 15.0
"""Errors beyond it have the last colour of the map."""


def distance(
    connection: duckdb.DuckDBPyConnection, soils: Sequence[str], case: Combination, approaches: Sequence[str]
) -> Figure:
    """Draw levels against distance, a column per soil: all bands together, and some octaves by themselves."""
    rows = connection.execute(
        "SELECT soil, approach, offset_m, band_hz, mean_square FROM levels WHERE list_contains($1, soil) "
        "AND track = $2 AND train = $3 AND unevenness = $4 AND speed_kmh = $5 AND receiver = 'ground' "
        "AND contribution = 'dynamic' AND averaging = 'line' ORDER BY offset_m",
        [list(soils), case.track, case.train, case.unevenness, case.speed_kmh],
    ).fetchall()
    bands = sorted({row[3] for row in rows})
    shown: list[float | None] = [None]
    shown += [each for each in bands if any(abs(each / wanted - 1.0) < 0.1 for wanted in _SHOWN_BANDS_HZ)]
    figure, panels = page(len(shown), len(soils), 1.75)
    shared = Legend()
    for row, at in enumerate(shown):
        for column, soil in enumerate(soils):
            axis = panels[row][column]
            for approach in approaches:
                level = _against_distance([each for each in rows if each[:2] == (soil, approach)], at)
                if level:
                    shared.curve(
                        axis, np.array(list(level)), np.array(list(level.values())), approach_line(approach)
                    )
            level_axis(axis)
            what = "all bands" if at is None else f"{band(at)} Hz"
            name_panel(axis, row * len(soils) + column, f"{soil}, {what}")
            label(
                axis,
                "distance from the track's centre [m]" if row == len(shown) - 1 else None,
                "level [dB re 1e-9 m/s]" if column == 0 else None,
            )
    shared.show(figure)
    return figure


def _against_distance(rows: Sequence[tuple[Any, ...]], at: float | None) -> dict[float, float]:
    """Return the level [dB] by offset [m], in one band or all together."""
    sums: dict[float, float] = {}
    for _, _, offset, band_hz, mean_square in rows:
        if at is None or band_hz == at:
            sums[offset] = sums.get(offset, 0.0) + mean_square
    return {offset: 10.0 * math.log10(total * 1e18) for offset, total in sums.items() if total > 0}


def error_map(
    connection: duckdb.DuckDBPyConnection, soils: Sequence[str], approach: str, against: str
) -> Figure:
    """Draw the mean error on the ground over band and speed; over band and distance if there is one speed."""
    row = connection.execute("SELECT count(DISTINCT speed_kmh) FROM cases").fetchone()
    by = "speed_kmh" if row and row[0] > 1 else "offset_m"
    found = connection.execute(
        f"SELECT soil, {by}, band_hz, avg(error_db) FROM accuracy WHERE list_contains($1, soil) "
        "AND approach = $2 AND receiver = 'ground' AND contribution = 'dynamic' GROUP BY ALL ORDER BY ALL",
        [list(soils), approach],
    ).fetchall()
    height = max(1.6, 0.9 + 0.16 * len({each[1] for each in found}))
    figure, panels = page(len(soils), 1, height, named=False)
    figure.subplots_adjust(right=0.94)  # for what the colours mean
    for number, soil in enumerate(soils):
        axis = panels[number][0]
        own = [each[1:] for each in found if each[0] == soil]
        rows, bands = sorted({each[0] for each in own}), sorted({each[1] for each in own})
        values = np.full((len(rows), len(bands)), np.nan)
        for value, band_hz, error in own:
            values[rows.index(value), bands.index(band_hz)] = error
        picture = axis.pcolormesh(values, cmap="RdBu_r", vmin=-_MOST_DB, vmax=_MOST_DB)
        axis.grid(False)
        axis.set_xticks(np.arange(0, len(bands), 3) + 0.5, [band(each) for each in bands[::3]])
        axis.set_yticks(np.arange(len(rows)) + 0.5, [f"{each:g}" for each in rows])
        name_panel(
            axis, number, f"{soil}: {approach_line(approach).label} minus {approach_line(against).label}"
        )
        label(
            axis,
            "one-third octave [Hz]" if number == len(soils) - 1 else None,
            "speed [km/h]" if by == "speed_kmh" else "distance [m]",
        )
        bar = figure.colorbar(picture, ax=axis, pad=0.015, fraction=0.03)
        bar.set_label("error [dB]", fontsize=8)
        bar.ax.tick_params(labelsize=7)
    return figure


def cost(connection: duckdb.DuckDBPyConnection, approaches: Sequence[str]) -> Figure:
    """Draw error against cost, a point per case and approach; the reference has no error."""
    figure, ((axis,),) = page(1, 1, 2.8, named=False)
    found = connection.execute(
        "SELECT approach, cpu_s, mean_absolute_error_db FROM tradeoff WHERE contribution = 'dynamic' "
        "AND quantity = 'velocity' UNION ALL SELECT approach, cpu_s, 0 FROM runtime "
        "WHERE approach = reference AND missing_units = 0"
    ).fetchall()
    handles: list[Artist] = []
    names: list[str] = []
    for approach in approaches:
        points = [each[1:] for each in found if each[0] == approach and each[1]]
        if points:
            line = approach_line(approach)
            (handle,) = axis.plot(
                *np.array(points).T,
                linestyle="",
                marker=line.marker,
                color=line.colour,
                markersize=1.4 * line.marker_size,
                clip_on=False,
            )
            handles.append(handle)
            names.append(line.label)
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_locator(NullLocator())
    if handles:
        costs = [each[1] for each in found if each[1]]
        axis.set_xlim(min(costs) / 1.6, max(costs) * 1.6)
    axis.set_ylim(bottom=0.0)
    label(axis, "processor time of a case [s]", "mean |error| of the velocity [dB]")
    if handles:
        legend(figure, handles, names)
    return figure
