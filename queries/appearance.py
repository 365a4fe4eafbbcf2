"""How figures for print look: one page width, one frequency axis, legends outside of the data."""

import math

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from queries.lines import plain
from queries.table import band

WIDTH_IN = 7.2
"""Width of a page's text, inch."""
DOTS_PER_INCH = 180
_EDGE_IN = 0.5
"""Height of the strip above the panels that holds legend and panel names, inch."""
_FONT = 8.5
_GRID = "#d9d9d9"


def page(
    rows: int, columns: int, panel_height_in: float = 2.1, named: bool = True
) -> tuple[Figure, list[list[Axes]]]:
    """Return a figure of a page's width with panels under a strip for the legend and names of panels."""
    edge = _EDGE_IN if named else 0.6 * _EDGE_IN
    height = rows * panel_height_in + edge + 0.2
    figure = Figure(figsize=(WIDTH_IN, height), dpi=DOTS_PER_INCH)
    FigureCanvasAgg(figure)
    panels = figure.subplots(rows, columns, squeeze=False)
    figure.subplots_adjust(
        left=0.085 if columns < 3 else 0.075,
        right=0.985,
        bottom=0.42 / height,
        top=1.0 - edge / height,
        wspace=0.2,
        hspace=0.62 / panel_height_in,
    )
    axes = [list(row) for row in panels]
    for axis in (axis for row in axes for axis in row):
        axis.grid(True, which="major", color=_GRID, linewidth=0.6)
        axis.set_axisbelow(True)
        axis.tick_params(labelsize=_FONT - 1, direction="out")
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    return figure, axes


def name_panel(axis: Axes, number: int, text: str, alone: bool = False) -> None:
    """Write what a panel shows above it, with its letter unless it is alone."""
    letter = "" if alone else f"({chr(ord('a') + number)}) "
    axis.set_title(letter + plain(text), fontsize=_FONT, loc="left", parse_math=False, y=1.02)


def legend(figure: Figure, handles: list[Artist], labels: list[str]) -> None:
    """Put one legend above all panels, outside of the data."""
    columns = min(len(handles), 4 if max(map(len, labels), default=0) < 24 else 3)
    shown = figure.legend(
        handles,
        labels,
        loc="upper center",
        ncols=columns,
        fontsize=_FONT - 0.5,
        frameon=False,
        handlelength=3.2,
        borderaxespad=0.2,
    )
    for text in shown.get_texts():
        text.set_parse_math(False)


def label(axis: Axes, horizontal: str | None, vertical: str | None) -> None:
    """Name the axes, with units."""
    if horizontal:
        axis.set_xlabel(horizontal, fontsize=_FONT, labelpad=2)
    if vertical:
        axis.set_ylabel(vertical, fontsize=_FONT, labelpad=2)


def level_axis(axis: Axes) -> None:
    """Put ticks at whole decibels."""
    axis.yaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 5, 10], integer=True))


def band_axis(axis: Axes, lowest: float, highest: float, downwards: bool = False) -> None:
    """Make the horizontal axis logarithmic, with a tick and a number at every octave.

    Parameters
    ----------
    axis
        The panel.
    lowest, highest
        Ends of the data, Hz or m.
    downwards
        Show the largest value at the left.
    """
    first, last = round(10 * math.log10(lowest)), round(10 * math.log10(highest))
    bands = np.arange(first, last + 1)
    named = bands[bands % 3 == 0]
    if named.size > 14:
        named = bands[bands % 10 == 0]
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(FixedLocator((10.0 ** (named / 10)).tolist()))
    axis.xaxis.set_minor_locator(NullLocator())  # a third of the time went into ticks without a number
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: band(value)))
    ends = (10.0 ** ((first - 0.5) / 10), 10.0 ** ((last + 0.5) / 10))
    axis.set_xlim(*(ends[::-1] if downwards else ends))
