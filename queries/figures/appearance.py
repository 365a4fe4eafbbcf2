"""Appearance of figures for print: one page width, one frequency axis, legends outside the data."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator
from numpy.typing import NDArray

from queries.answers import band, plain
from queries.figures.lines import Line

WIDTH_IN = 7.2
"""Width of a page's text, inch."""
DOTS_PER_INCH = 180
_EDGE_IN = 0.5
"""Height of the strip above the panels that holds legend and panel names, inch."""
_LEGEND_LINE_IN = 0.17
_TICK_IN = 0.28
"""Width of the number at a tick, inch."""
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
        self.renderer = FigureCanvasAgg(self).get_renderer()  # type: ignore[no-untyped-call]
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

    def fit(self, panel_height_in: float, named: bool, legend_lines: int = 1) -> None:
        """Set the height of all panels, with space above them for names and legend lines."""
        self.panel_height_in, self.named = panel_height_in, named
        rows, columns = self.form
        edge = (_EDGE_IN if named else 0.6 * _EDGE_IN) + _LEGEND_LINE_IN * (legend_lines - 1)
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
        """Clear all panels, and return whether they are as new."""
        rows, columns = self.form
        if len(self.axes) != rows * columns or any(
            axis.collections or axis.images or axis.patches for axis in self.axes
        ):
            return False
        of_panels = (artist for axis in self.axes for artist in (*axis.lines, *axis.texts))
        for artist in (*self.legends, *self.texts, *of_panels):
            artist.remove()
        for axis in self.axes:
            axis.set_visible(True)
            axis.set_title("", loc="left")
            axis.set(xlabel="", ylabel="", xscale="linear", yscale="linear")
            axis.relim()
            axis.autoscale(True)
        return True


_emptied: dict[tuple[int, int], list[Page]] = {}
"""Pages that can be reused, by their rows and columns."""


def page(
    rows: int, columns: int, panel_height_in: float = 2.1, named: bool = True
) -> tuple[Figure, list[list[Axes]]]:
    """Return a page and its panels."""
    waiting = _emptied.get((rows, columns))
    figure = waiting.pop() if waiting else Page(rows, columns)
    figure.fit(panel_height_in, named)
    return figure, figure.panels


def take_back(figure: Figure) -> None:
    """Keep a finished page for the next figure of its form: panels cost more time than curves."""
    if isinstance(figure, Page) and figure.empty():
        _emptied.setdefault(figure.form, []).append(figure)


def name_panel(axis: Axes, number: int, text: str, alone: bool = False) -> None:
    """Write a panel's name above it, with a letter unless it is alone, cut to its width."""
    letter = "" if alone else f"({_letter(number)}) "
    title = axis.set_title(letter + plain(text), fontsize=_FONT, loc="left", parse_math=False, y=1.02)
    figure = axis.get_figure()
    assert isinstance(figure, Page)
    room = _width_in(axis) * figure.dpi
    renderer = figure.renderer
    whole = title.get_text()
    while title.get_window_extent(renderer).width > room and len(whole) > len(letter) + 1:
        whole = whole[:-1]
        title.set_text(f"{whole.rstrip(', ')}…")


def _letter(number: int) -> str:
    """Return a, b, …, z, aa, ab, …."""
    more, place = divmod(number, 26)
    return (_letter(more - 1) if more else "") + chr(ord("a") + place)


def annotate(figure: Figure, note: str) -> None:
    """Write the note of a figure at its lower edge."""
    figure.text(0.985, 0.004, plain(note), fontsize=_FONT - 1.5, ha="right", va="bottom", parse_math=False)


class Legend:
    """Collects one handle per label, so that panels share one legend."""

    def __init__(self) -> None:
        self.handles: dict[str, Artist] = {}

    def curve(
        self,
        axis: Axes,
        x: NDArray[Any],
        y: NDArray[Any],
        line: Line,
        *,
        markers: bool = True,
        width: float | None = None,
        hollow: NDArray[np.bool_] | None = None,
    ) -> None:
        """Draw a line and keep its handle; markers are hollow where unevenness is mostly extrapolated."""
        outside = np.zeros(x.size, bool) if hollow is None else hollow
        (handle,) = axis.plot(
            x,
            y,
            color=line.colour,
            linestyle=(0, line.dashes) if line.dashes else "-",
            marker=line.marker if markers else None,
            markevery=np.flatnonzero(~outside).tolist() if outside.any() else None,
            markersize=line.marker_size,
            linewidth=width or line.width,
            zorder=line.order,
        )
        self.handles.setdefault(line.label, handle)
        if outside.any():
            (mark,) = axis.plot(
                x[outside],
                y[outside],
                line.marker,
                color="white",
                markeredgecolor=line.colour,
                markersize=line.marker_size + 0.4,
                zorder=line.order + 0.05,
            )
            self.handles.setdefault("unevenness mostly extrapolated", mark)

    def show(self, figure: Figure) -> None:
        """Put the legend above the panels, outside of the data."""
        if not self.handles:
            return
        columns = min(len(self.handles), 4 if max(map(len, self.handles)) < 24 else 3)
        lines = math.ceil(len(self.handles) / columns)
        if lines > 1 and isinstance(figure, Page):
            figure.fit(figure.panel_height_in, figure.named, lines)
        legend = figure.legend(
            list(self.handles.values()),
            list(self.handles),
            loc="upper center",
            ncols=columns,
            fontsize=_FONT - 0.5,
            frameon=False,
            handlelength=3.2,
            borderaxespad=0.2,
        )
        for text in legend.get_texts():
            text.set_parse_math(False)


def same_range(axes: Sequence[Axes]) -> None:
    """Give panels that are compared one range of levels."""
    ranges = [axis.get_ylim() for axis in axes if axis.lines]
    if ranges:
        low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
        margin = 0.03 * (high - low)  # so that markers at the edge are not cut
        for axis in axes:
            axis.set_ylim(low - margin, high + margin)


def label(axis: Axes, horizontal: str | None, vertical: str | None) -> None:
    """Name the axes, with units."""
    if horizontal:
        axis.set_xlabel(horizontal, fontsize=_FONT, labelpad=2)
    if vertical:
        axis.set_ylabel(vertical, fontsize=_FONT, labelpad=2)


def level_axis(axis: Axes) -> None:
    """Put ticks at whole decibels."""
    axis.yaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 5, 10], integer=True))


def _width_in(axis: Axes) -> float:
    """Return the width of a panel, inch."""
    figure = axis.get_figure()
    assert isinstance(figure, Figure)
    return float(axis.get_position().width * figure.get_figwidth())


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
    room = round(_width_in(axis) / _TICK_IN)
    if named.size > room:
        named = bands[bands % (6 if bands.size <= 6 * room else 10) == 0]
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(FixedLocator((10.0 ** (named / 10)).tolist()))
    axis.xaxis.set_minor_locator(NullLocator())  # minor ticks took a third of the time
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: band(value)))
    ends = (10.0 ** ((first - 0.5) / 10), 10.0 ** ((last + 0.5) / 10))
    axis.set_xlim(*(ends[::-1] if downwards else ends))
