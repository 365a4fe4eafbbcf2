"""A figure to be drawn: its file name, its caption, and what it leaves out."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Item = TypeVar("Item")

_LONGEST_NAME = 200
"""Characters of a file name before a number and the extension; file systems allow 255."""


@dataclass(frozen=True)
class Drawing:
    """A figure to be drawn.

    Attributes
    ----------
    name
        Of its file, without ending.
    caption
        What it shows, and what it leaves out.
    draw
        Draws it.
    note
        What it leaves out, written on the figure; may be empty.
    """

    name: str
    caption: str
    draw: Callable[[], "Figure"]
    note: str = ""

    def leaving_out(self, *notes: str) -> "Drawing":
        """Return the drawing with notes on what it leaves out; empty notes are skipped."""
        parts = [part for part in notes if part]
        note = " ".join([self.note, *parts]).strip()
        return replace(self, note=note, caption=" ".join([self.caption, *parts]))


class Combination(NamedTuple):
    """A track, train, unevenness and speed, which several soils may share."""

    track: str
    train: str
    unevenness: str
    speed_kmh: float

    def __str__(self) -> str:
        """Return its text in captions."""
        return f"{self.train} on {self.track}, {self.unevenness}, {self.speed_kmh:g} km/h"


def sample(items: Sequence[Item], most: int) -> list[Item]:
    """Return a limited number of items, evenly spread, including the first and the last."""
    if len(items) <= most:
        return list(items)
    return [items[round(place)] for place in np.linspace(0, len(items) - 1, most)]


def shown_of(shown: Sequence[Any], every: Sequence[Any], things: str) -> str:
    """Return a note on how many things are shown; empty if all are."""
    return f"{len(shown)} of {len(every)} {things} are shown." if len(shown) < len(every) else ""


class FileNames:
    """Gives every figure a unique file name of plain letters."""

    def __init__(self, combinations: Sequence[Combination]) -> None:
        columns = zip(*combinations, strict=True)
        self._varying = [place for place, values in enumerate(columns) if len(set(values)) > 1]
        self._taken: set[str] = set()

    def name(
        self, number: int, topic: str, soil: str | None = None, combination: Combination | None = None
    ) -> str:
        """Return the next name of a figure with this number and topic."""
        parts = [f"figure-{number:02d}-{topic}", *([soil] if soil is not None else [])]
        if combination is not None:
            values = (*combination[:-1], f"{combination.speed_kmh:g}-kmh")
            parts += [values[place] for place in self._varying]
        base = "-".join(re.sub(r"[^a-z0-9]+", "-", part.lower()).strip("-") for part in parts)[:_LONGEST_NAME]
        free = next(name for name in self._candidates(base) if name not in self._taken)
        self._taken.add(free)
        return free

    @staticmethod
    def _candidates(base: str) -> Iterator[str]:
        yield base
        number = 2
        while True:
            yield f"{base}-{number}"
            number += 1
