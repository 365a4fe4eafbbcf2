"""How results look in every figure: one line per approach, one frequency axis, one page width.

Colours are those of Okabe and Ito (2008), told apart by colour-blind readers; dashes and markers tell them
apart in grey.
"""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter

from queries.table import band, printable

WIDTH_IN = 7.2
"""Width of a page's text, inch."""
DOTS_PER_INCH = 180
_EDGE_IN = 0.5
"""Height of the strip above the panels that holds legend and panel names, inch."""
_FONT = 8.5
_GRID = "#d9d9d9"


@dataclass(frozen=True)
class Line:
    """Colour, dashes and marker of a line, and what its legend says."""

    colour: str
    dashes: str | tuple[float, tuple[float, ...]]
    marker: str
    label: str
    width: float = 1.3
    marker_size: float = 3.0
    order: float = 2.2


_APPROACHES = {
    # Broad and underneath: where the others agree with it, they are seen on it.
    "full": Line("#000000", "-", "o", "full model", width=2.0, marker_size=4.6, order=2.1),
    "moving-roughness": Line("#0072B2", (0, (5, 1.5)), "s", "moving roughness"),
    "moving-roughness-by-axle": Line("#009E73", (0, (1, 1.2)), "D", "moving roughness by axle"),
    "moving-roughness-uncorrelated": Line(
        "#D55E00", (0, (5, 1.2, 1, 1.2)), "^", "moving roughness, uncorrelated axles"
    ),
    "fe-be": Line("#CC79A7", (0, (3, 1, 1, 1, 1, 1)), "v", "finite and boundary elements"),
}
_COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_DASHES: tuple[str | tuple[float, tuple[float, ...]], ...] = (
    "-",
    (0, (5, 1.5)),
    (0, (5, 1.2, 1, 1.2)),
    (0, (1, 1.2)),
)
_MARKERS = "os^Dv<>"


def approach_line(approach: str) -> Line:
    """Return the line of an approach, the same in every figure."""
    return _APPROACHES.get(approach, Line("#8a6d00", (0, (3, 1)), "x", plain(approach)))


def numbered_line(number: int, label: str) -> Line:
    """Return the line of the so-many-th thing of one kind, such as a speed."""
    return Line(
        _COLOURS[number % len(_COLOURS)],
        _DASHES[number % len(_DASHES)],
        _MARKERS[number % len(_MARKERS)],
        plain(label),
    )


def plain(text: str) -> str:
    """Return a name as the text of a figure; a leading underscore would hide it from a legend."""
    text = printable(text)
    return f" {text}" if text.startswith("_") else text


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
        axis.tick_params(which="minor", length=2)
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
    """Make the horizontal axis logarithmic: a tick at every one-third octave, a number at every octave.

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
    axis.xaxis.set_minor_locator(FixedLocator((10.0 ** (bands / 10)).tolist()))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: band(value)))
    axis.xaxis.set_minor_formatter(NullFormatter())
    ends = (10.0 ** ((first - 0.5) / 10), 10.0 ** ((last + 0.5) / 10))
    axis.set_xlim(*(ends[::-1] if downwards else ends))
