"""How figures for print look: one page width, one frequency axis, legends outside of the data."""

import math

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from queries.answers.table import band
from queries.figures.lines import plain

WIDTH_IN = 7.2
"""Width of a page's text, inch."""
DOTS_PER_INCH = 180
_EDGE_IN = 0.5
"""Height of the strip above the panels that holds legend and panel names, inch."""
_FONT = 8.5
_GRID = "#d9d9d9"


class Page(Figure):
    """A figure of a page's width with panels under a strip for the legend and names of panels.

    Parameters
    ----------
    rows, columns
        Of panels.
    """

    def __init__(self, rows: int, columns: int) -> None:
        super().__init__(dpi=DOTS_PER_INCH)
        FigureCanvasAgg(self)
        self.panels = [list(row) for row in self.subplots(rows, columns, squeeze=False)]
        for axis in self.axes:
            axis.grid(True, which="major", color=_GRID, linewidth=0.6)
            axis.set_axisbelow(True)
            axis.tick_params(labelsize=_FONT - 1, direction="out")
            for side in ("top", "right"):
                axis.spines[side].set_visible(False)

    @property
    def form(self) -> tuple[int, int]:
        """Rows and columns of panels."""
        return len(self.panels), len(self.panels[0])

    def fit(self, panel_height_in: float, named: bool) -> None:
        """Give all panels a height, and names a place above them."""
        rows, columns = self.form
        edge = _EDGE_IN if named else 0.6 * _EDGE_IN
        height = rows * panel_height_in + edge + 0.2
        self.set_size_inches(WIDTH_IN, height)
        self.subplots_adjust(
            left=0.085 if columns < 3 else 0.075,
            right=0.985,
            bottom=0.42 / height,
            top=1.0 - edge / height,
            wspace=0.2,
            hspace=0.62 / panel_height_in,
        )

    def empty(self) -> bool:
        """Take off what has been drawn on the panels, and return whether they are as they were made."""
        rows, columns = self.form
        if len(self.axes) != rows * columns or any(
            axis.collections or axis.images or axis.patches for axis in self.axes
        ):
            return False
        for artist in (*self.legends, *(each for axis in self.axes for each in (*axis.lines, *axis.texts))):
            artist.remove()
        for axis in self.axes:
            axis.set_visible(True)
            axis.set_title("", loc="left")
            axis.set(xlabel="", ylabel="", xscale="linear", yscale="linear")
            axis.relim()
            axis.autoscale(True)
        return True


_emptied: dict[tuple[int, int], list[Page]] = {}
"""Pages that have been written, by their rows and columns."""


def page(
    rows: int, columns: int, panel_height_in: float = 2.1, named: bool = True
) -> tuple[Figure, list[list[Axes]]]:
    """Return a page and its panels."""
    waiting = _emptied.get((rows, columns))
    figure = waiting.pop() if waiting else Page(rows, columns)
    figure.fit(panel_height_in, named)
    return figure, figure.panels


def take_back(figure: Figure) -> None:
    """Take a figure that has been written for the next of its form: panels cost more than their curves."""
    if isinstance(figure, Page) and figure.empty():
        _emptied.setdefault(figure.form, []).append(figure)


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
