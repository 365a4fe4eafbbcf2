"""Colours, dashes and markers: one line per approach, the same in every figure and in the report.

Colours are those of Okabe and Ito (2008), told apart by colour-blind readers; dashes and markers tell them
apart in grey.
"""

from dataclasses import dataclass, replace

from queries.answers import label, plain


@dataclass(frozen=True)
class Line:
    """Colour, dashes and marker of a line, and its entry in a legend.

    Attributes
    ----------
    dashes
        Lengths of strokes and gaps in widths of the line; none for a solid line.
    marker
        In Matplotlib's letters.
    """

    colour: str
    dashes: tuple[float, ...]
    marker: str
    label: str = ""
    width: float = 1.3
    marker_size: float = 3.0
    order: float = 2.2


_APPROACHES = {
    # Broad and underneath: where the others agree with it, they are seen on it.
    "full": Line("#000000", (), "o", width=2.0, marker_size=4.6, order=2.1),
    "moving-roughness": Line("#0072B2", (5, 1.5), "s"),
    "moving-roughness-by-axle": Line("#009E73", (1, 1.2), "D"),
    "moving-roughness-uncorrelated": Line("#D55E00", (5, 1.2, 1, 1.2), "^"),
    "fe-be": Line("#CC79A7", (3, 1, 1, 1, 1, 1), "v"),
}
_UNKNOWN = Line("#8a6d00", (3, 1), "x")
_COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_DASHES: tuple[tuple[float, ...], ...] = ((), (5, 1.5), (5, 1.2, 1, 1.2), (1, 1.2))
_MARKERS = "os^Dv<>"
DISTINCT = len(_MARKERS)
"""Lines of `numbered_line` that can be told apart."""


def approach_line(approach: str) -> Line:
    """Return the line of an approach, the same in every figure."""
    return replace(_APPROACHES.get(approach, _UNKNOWN), label=label(approach))


def numbered_line(number: int, name: str) -> Line:
    """Return the line of the so-many-th thing of one kind, such as a speed."""
    return Line(
        _COLOURS[number % len(_COLOURS)],
        _DASHES[number % len(_DASHES)],
        _MARKERS[number % len(_MARKERS)],
        plain(name),
    )
