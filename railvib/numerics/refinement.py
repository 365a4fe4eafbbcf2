"""Refinement until a check passes: levels of frequencies, and panels that are halved."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from railvib.numerics.wavenumber_panels import NODE

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
    """Panels of one coordinate, by where they begin and their widths, (n,)."""

    low: np.ndarray
    width: np.ndarray
    owner: np.ndarray
    """Which of several functions a panel belongs to."""

    @classmethod
    def between(cls, edge: np.ndarray) -> "Panels":
        """Return the panels of one function between ascending edges (n + 1,)."""
        return cls(edge[:-1], np.diff(edge), np.zeros(edge.size - 1, int))

    @property
    def centre(self) -> np.ndarray:
        """Centres, (n,)."""
        return self.low + 0.5 * self.width

    @property
    def nodes(self) -> np.ndarray:
        """Gauss–Legendre nodes, (n, order)."""
        return np.asarray(self.centre[:, None] + 0.5 * self.width[:, None] * NODE)

    def select(self, which: np.ndarray) -> "Panels":
        """Return some of the panels."""
        return Panels(self.low[which], self.width[which], self.owner[which])

    def halves(self) -> "Panels":
        """Return both halves of each panel, one after the other: their widths are equal to the last bit."""
        width = np.repeat(0.5 * self.width, 2)
        low = np.repeat(self.low, 2)
        low[1::2] += width[1::2]
        return Panels(low, width, np.repeat(self.owner, 2))


def halve(
    panels: Panels,
    evaluate: Callable[[Panels], tuple[np.ndarray, np.ndarray]],
    most: int,
) -> tuple[Panels, np.ndarray]:
    """Halve panels until they are resolved.

    Parameters
    ----------
    panels
        The first panels.
    evaluate
        Returns values of panels, (n, …), and which of them are not resolved, (n,).
    most
        How many times a panel is halved at most.

    Returns
    -------
    panels, values
        The panels, in the order in which they were finished, and their values.
    """
    parts: list[Panels] = []
    values: list[np.ndarray] = []
    for halving in range(most + 1):
        value, unresolved = evaluate(panels)
        unresolved &= halving < most
        parts.append(panels.select(~unresolved))
        values.append(value[~unresolved])
        if not unresolved.any():
            break
        panels = panels.select(unresolved).halves()
    return Panels(*(np.concatenate(columns) for columns in zip(*parts, strict=True))), np.concatenate(values)


def divide(edge: np.ndarray, parts: int) -> np.ndarray:
    """Return ascending edges (n + 1,) with every panel divided into equal parts, (n × parts + 1,)."""
    place = np.arange(parts * (edge.size - 1) + 1) / parts
    return np.asarray(np.interp(place, np.arange(edge.size), edge))
