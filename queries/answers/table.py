"""A table for people: headings with units and cells of text, the same in a terminal and in a page."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


_UNBOUNDED = 100_000


@dataclass(frozen=True)
class Table:
    """A table of text.

    Attributes
    ----------
    title, note
        What it shows, and how to read it.
    columns
        Headings, with units.
    rows
        Cells, as many per row as there are columns.
    words
        Number of columns of words, on the left; the others hold numbers and are right-aligned.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int = 1
    note: str = ""

    def show(self, console: "Console") -> None:
        """Print the table; in a file it is not folded."""
        from rich.box import SIMPLE_HEAD
        from rich.console import Console
        from rich.table import Table as Grid
        from rich.text import Text

        if self.title:
            console.print(Text(printable(self.title), style="bold"), soft_wrap=not console.is_terminal)
        grid = Grid(
            header_style="bold",
            box=SIMPLE_HEAD,
            pad_edge=False,
            padding=(0, 1, 0, 0),
        )
        for number, heading in enumerate(self.columns):
            grid.add_column(
                Text(printable(heading)), justify="left" if number < self.words else "right", overflow="fold"
            )
        if console.is_terminal:
            for row in self.rows:
                grid.add_row(*(Text(printable(cell)) for cell in row))
        else:  # a file has no width: nothing is folded
            if self.rows:  # one row of many lines is faster: a row takes half a millisecond
                columns = zip(*self.rows, strict=True)
                grid.add_row(*(Text("\n".join(map(printable, column))) for column in columns))
            console = Console(file=console.file, width=_UNBOUNDED)
            console.width = max(console.measure(grid).maximum, len(self.note))
        console.print(grid)
        if self.note:
            console.print(Text(self.note, style="dim"))


def printable(text: str) -> str:
    """Return text without control characters."""
    return "".join(character if character.isprintable() else " " for character in text)


def plain(text: str) -> str:
    """Return a name for figures and sentences; Matplotlib hides labels that begin with an underscore."""
    text = printable(text)
    return f" {text}" if text.startswith("_") else text


def number(value: float | None, digits: int = 3) -> str:
    """Return a number rounded to significant digits, without an exponent; a dash for None."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:,.{min(decimals, 6)}f}"


def decibels(value: float | None) -> str:
    """Return a difference of levels with its sign and one decimal."""
    return "–" if value is None else f"{round(value, 1) + 0.0:+.1f}"  # + 0.0: no minus before zero


def band(value: float) -> str:
    """Return the nominal name of a one-third octave, such as 31.5 for 31.62 Hz (IEC 61260-1)."""
    nominal = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
    decade, place = divmod(round(10 * math.log10(value)), 10)
    return f"{nominal[place] * 10.0**decade:.4g}"
