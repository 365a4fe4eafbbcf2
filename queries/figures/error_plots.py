"""Error over speed and band, and error against cost (Figures 12 and 13)."""

from collections.abc import Sequence

import duckdb
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from queries.answers import band
from queries.answers import label as label_of
from queries.figures.appearance import Legend, label, name_panel, page
from queries.figures.lines import approach_line
from queries.statements import statements

_SQL = statements("queries.figures", "plots")
_LEAST_DB, _MOST_DB = 3.0, 15.0
"""Ends of the colour scale of errors."""


def error_map(
    connection: duckdb.DuckDBPyConnection, soils: Sequence[str], approach: str, against: str
) -> Figure:
    """Draw the mean size of the error on the ground over band and speed; over distance at one speed."""
    row = connection.execute("SELECT count(DISTINCT speed_kmh) FROM cases").fetchone()
    by = "speed_kmh" if row and row[0] > 1 else "offset_m"
    rows = connection.execute(_SQL["errors"].format(by=by), [list(soils), approach]).fetchall()
    largest = min(max([_LEAST_DB, *(size for *_, size in rows)]), _MOST_DB)
    height = max(1.6, 0.9 + 0.16 * len({value for _, value, _, _ in rows}))
    figure, panels = page(len(soils), 1, height, named=False)
    figure.subplots_adjust(right=0.94)  # for the scale of colours
    for number, soil in enumerate(soils):
        axis = panels[number][0]
        of_soil = [row[1:] for row in rows if row[0] == soil]
        values, bands = sorted({row[0] for row in of_soil}), sorted({row[1] for row in of_soil})
        sizes = np.full((len(values), len(bands)), np.nan)
        for value, band_hz, size in of_soil:
            sizes[values.index(value), bands.index(band_hz)] = size
        picture = axis.pcolormesh(sizes, cmap="YlOrRd", vmin=0.0, vmax=largest)
        axis.grid(False)
        axis.set_xticks(np.arange(0, len(bands), 3) + 0.5, [band(band_hz) for band_hz in bands[::3]])
        axis.set_yticks(np.arange(len(values)) + 0.5, [f"{value:g}" for value in values])
        name_panel(axis, number, f"{soil}: {label_of(approach)} against {label_of(against)}")
        label(
            axis,
            "one-third octave [Hz]" if number == len(soils) - 1 else None,
            "speed [km/h]" if by == "speed_kmh" else "distance [m]",
        )
        bar = figure.colorbar(
            picture, ax=axis, pad=0.015, fraction=0.03, extend="max" if largest == _MOST_DB else "neither"
        )
        bar.set_label("mean |error| [dB]", fontsize=8)
        bar.ax.tick_params(labelsize=7)
    return figure


def cost(connection: duckdb.DuckDBPyConnection, approaches: Sequence[str], place: str) -> Figure:
    """Draw error against cost, a point per case and approach; the reference has no error.

    Parameters
    ----------
    connection
        Results.
    approaches
        Which are shown.
    place
        ground or rail, where the velocity is compared.
    """
    figure, ((axis,),) = page(1, 1, 2.8, named=False)
    rows = connection.execute(_SQL["costs"], [place]).fetchall()
    legend = Legend()
    costs = [cpu for _, cpu, _ in rows if cpu]
    for approach in approaches:
        points = np.array([(cpu, error) for name, cpu, error in rows if name == approach and cpu])
        if points.size:
            line = approach_line(approach)
            (handle,) = axis.plot(
                *points.T,
                linestyle="",
                marker=line.marker,
                color=line.colour,
                markersize=1.4 * line.marker_size,
                clip_on=False,
            )
            legend.handles[line.label] = handle
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_locator(NullLocator())
    if costs:
        axis.set_xlim(min(costs) / 1.6, max(costs) * 1.6)
    axis.set_ylim(bottom=0.0)
    where = {"ground": "on the ground", "rail": "of the rail"}[place]
    label(axis, "processor time of a case [s]", f"mean |error| of the velocity {where} [dB]")
    legend.show(figure)
    return figure
