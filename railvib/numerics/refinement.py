"""Refinement until a check passes: levels of frequencies, and panels that are halved."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol, Self, TypeVar

import numpy as np

Item = TypeVar("Item")
Result = TypeVar("Result")

MOST_LEVELS = 6
"""Level of frequencies beyond which no finer one is tried."""


def search_levels(
    start: Mapping[Item, int],
    tabulate: Callable[[int, Sequence[Item]], Callable[[Item, bool], tuple[Result, bool]]],
    last: int = MOST_LEVELS,
    beyond: int = 0,
) -> Iterator[dict[Item, tuple[int, Result]]]:
    """Yield the results of items as each of them reaches the first level that passes its check.

    Parameters
    ----------
    start
        The first level that is tried for each item.
    tabulate
        Called with a level and the items to be tabulated at it, all that need it together. Returns a check,
        which is called with an item, and with whether a result is required; it returns the item's result, and
        whether that passes. Where a result is not required, that of a check that fails may be anything.
    last
        Level from which on results are required, and pass.
    beyond
        Number of levels beyond the first that passes at which a result is taken, for studies of convergence.

    Yields
    ------
    dict
        Level and result of the items that need no finer level.
    """
    pending = dict(start)
    passed: dict[Item, int] = {}
    while pending:
        level = min(pending.values())
        items = [item for item, next_level in pending.items() if next_level == level]
        check = tabulate(level, items)
        finished: dict[Item, tuple[int, Result]] = {}
        for item in items:
            required = item in passed or level >= last
            result, passes = check(item, required)
            if passes or required:
                passed.setdefault(item, level)
            if item in passed and level >= passed[item] + beyond:
                finished[item] = level, result
                del pending[item]
            else:
                pending[item] += 1
        if finished:
            yield finished


def search_level(
    start: int, check: Callable[[int, bool], tuple[Result, bool]], last: int = MOST_LEVELS
) -> tuple[int, Result]:
    """Return the first level that passes a check, and its result, as `search_levels` does for one item."""

    def tabulate(level: int, _items: Sequence[None]) -> Callable[[None, bool], tuple[Result, bool]]:
        return lambda _item, required: check(level, required)

    return next(search_levels({None: start}, tabulate, last))[None]


class Panels(NamedTuple):
    """Panels of one coordinate, by their edges, (n,)."""

    low: np.ndarray
    high: np.ndarray

    @classmethod
    def between(cls, edge: np.ndarray) -> "Panels":
        """Return the panels between ascending edges (n + 1,)."""
        return cls(edge[:-1], edge[1:])

    @property
    def edges(self) -> np.ndarray:
        """Both edges of each panel, (n, 2)."""
        return np.stack([self.low, self.high], axis=1)

    def select(self, which: np.ndarray) -> "Panels":
        """Return some of the panels."""
        return Panels(self.low[which], self.high[which])

    def halves(self) -> "Panels":
        """Return both halves of each panel, one after the other."""
        middle = 0.5 * (self.low + self.high)
        return Panels(
            np.stack([self.low, middle], axis=1).ravel(), np.stack([middle, self.high], axis=1).ravel()
        )


class Divisible(Protocol):
    """Panels in any form, some of which can be selected and halved."""

    def select(self, which: np.ndarray) -> Self:
        """Return some of the panels."""

    def halves(self) -> Self:
        """Return both halves of each panel."""


PanelSet = TypeVar("PanelSet", bound=Divisible)


def halve(
    panels: PanelSet,
    evaluate: Callable[[PanelSet], tuple[np.ndarray, np.ndarray]],
    most: int,
) -> Iterator[tuple[PanelSet, np.ndarray]]:
    """Halve panels until they are resolved.

    Parameters
    ----------
    panels
        The first panels.
    evaluate
        Returns values of panels, (n, …), and which of them are not resolved, (n,).
    most
        How many times a panel is halved at most.

    Yields
    ------
    panels, values
        The panels that need not be halved further, and their values.
    """
    for halving in range(most + 1):
        values, unresolved = evaluate(panels)
        unresolved &= halving < most
        yield panels.select(~unresolved), values[~unresolved]
        if not unresolved.any():
            return
        panels = panels.select(unresolved).halves()


def divide(edge: np.ndarray, parts: int) -> np.ndarray:
    """Return ascending edges (n + 1,) with every panel divided into equal parts, (n × parts + 1,)."""
    place = np.arange(parts * (edge.size - 1) + 1) / parts
    return np.asarray(np.interp(place, np.arange(edge.size), edge))
