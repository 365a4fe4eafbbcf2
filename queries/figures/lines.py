"""Colours, dashes and markers: one line per approach, the same in every figure and in the report.

Colours are those of Okabe and Ito (2008), which colour-blind readers can distinguish; dashes and markers
serve in grey.
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
    # Broad and underneath, so that lines that agree with it stay visible.
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
"""Number of distinct lines of `numbered_line`."""


def approach_line(approach: str) -> Line:
    """Return the line of an approach, the same in every figure."""
    return replace(_APPROACHES.get(approach, _UNKNOWN), label=label(approach))


def numbered_line(number: int, name: str) -> Line:
    """Return the line with a number, such as that of a speed."""
    return Line(
        _COLOURS[number % len(_COLOURS)],
        _DASHES[number % len(_DASHES)],
        _MARKERS[number % len(_MARKERS)],
        plain(name),
    )
