"""All zeros of an analytic function in a rectangle, counted by its phase along the edges.

The function is given by its logarithm, in any turn of its phase: it may be larger than any number. The change
of phase around a rectangle counts the zeros inside (argument principle), the moments of that change say
roughly where they are, and Newton's method takes them from there. A rectangle of more zeros than this serves
is split, and the parts must hold as many as the whole.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

_FIRST_SAMPLES = 4
_OFFSET = 1e-6
"""Distance over which slopes are taken."""
_MOST_SURPRISE = 0.7
"""Largest difference of a step's change of phase from what the slopes at its ends predict, rad."""
_MOST_BEND = 1.5
"""Largest change of slope over a step times its length: a zero beside the step bends by 4, n zeros by 4n."""
_MOST_HALVINGS = 30
_MOST_AT_ONCE = 3
"""Zeros in one rectangle that are found from its moments."""
_SMALLEST = 1e-4
"""Diagonal of a rectangle that is not split any more."""
_CUTS = (0.4641, 0.5373, 0.3917, 0.6083)
"""Where a side is cut, in turn until the cut keeps clear of zeros."""
_MOST_STEPS = 40
_MOST_RATIO = 300.0
"""Largest change of the function's logarithm over a step of the search."""
_CONVERGED = 1e-13
_ACCEPTED = 1e-8
"""Last step of a search that rounding keeps from converging, as at two zeros next to each other."""

LogFunction = Callable[[np.ndarray], np.ndarray]


def zeros(log_function: LogFunction, low: complex, high: complex) -> np.ndarray:
    """Return all zeros of an analytic function in a rectangle, multiple ones as often as they count.

    Parameters
    ----------
    log_function
        Takes points (n,) and returns the logarithms of the function there, complex (n,), with a phase in any
        turn; −inf where the function is zero.
    low, high
        Lower left and upper right corner. The scale of what the function does should be about one.

    Returns
    -------
    ndarray of complex
        As many as the phase along the edges counts. Where more than three lie within 1e-4 of each other, the
        middle of the rectangle that holds them stands for each.

    Raises
    ------
    ArithmeticError
        If a zero lies on the edge, or no cut keeps clear of zeros.
    """
    return np.array(_zeros(log_function, low, high, _boundary(log_function, low, high)), complex)


class _Boundary(NamedTuple):
    """The closed path along a rectangle's edges."""

    middle: np.ndarray
    """Middles of its steps."""
    change: np.ndarray
    """Of the function's logarithm in each step."""

    @property
    def zero_count(self) -> int:
        """How many zeros are inside."""
        return round(float(self.change.imag.sum()) / (2.0 * np.pi))

    def starts(self, count: int, centre: complex) -> np.ndarray:
        """Return roughly where the zeros inside are, from the sums of their powers (Newton's identities)."""
        power = [
            ((self.middle - centre) ** order * self.change).sum() / (2j * np.pi)
            for order in range(1, count + 1)
        ]
        polynomial = [1.0 + 0j]
        for order in range(1, count + 1):
            terms = [polynomial[order - 1 - i] * power[i] for i in range(order)]
            polynomial.append(-sum(terms) / order)
        return np.asarray(centre + np.roots(polynomial))


def _boundary(log_function: LogFunction, low: complex, high: complex) -> _Boundary:
    """Sample the edges until every step's change of phase is sure."""
    corner = np.array([low, complex(high.real, low.imag), high, complex(low.real, high.imag)])
    side = np.roll(corner, -1) - corner
    share = np.arange(_FIRST_SAMPLES) / _FIRST_SAMPLES
    z = np.append((corner[:, None] + side[:, None] * share).ravel(), low)
    value, slope = _values_and_slopes(log_function, z)
    for _ in range(_MOST_HALVINGS):
        step = np.diff(z)
        expected = 0.5 * (slope[1:] + slope[:-1]) * step
        surprise = _wrap(np.diff(value) - expected)
        unsure = (np.abs(surprise.imag) > _MOST_SURPRISE) | (np.abs(np.diff(slope) * step) > _MOST_BEND)
        if not unsure.any():
            return _Boundary(0.5 * (z[1:] + z[:-1]), expected + surprise)
        place = np.flatnonzero(unsure)
        added = z[place] + 0.5 * step[place]
        new_value, new_slope = _values_and_slopes(log_function, added)
        z = np.insert(z, place + 1, added)
        value = np.insert(value, place + 1, new_value)
        slope = np.insert(slope, place + 1, new_slope)
    raise ArithmeticError("a zero lies on the edge")


def _values_and_slopes(log_function: LogFunction, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    value, beside = np.split(log_function(np.concatenate([z, z + _OFFSET])), 2)
    return value, _wrap(beside - value) / _OFFSET


def _wrap(change: np.ndarray) -> np.ndarray:
    """Return changes of a logarithm with a phase between −π and π."""
    return np.asarray(change.real + 1j * (np.remainder(change.imag + np.pi, 2.0 * np.pi) - np.pi))


def _zeros(log_function: LogFunction, low: complex, high: complex, boundary: _Boundary) -> list[complex]:
    count = boundary.zero_count
    if count == 0:
        return []
    size = high - low
    if count <= _MOST_AT_ONCE:
        starts = boundary.starts(count, 0.5 * (low + high))
        searched = _search(log_function, starts, low, high)
        if searched is not None:
            return searched
        if abs(size) < _SMALLEST:
            return [complex(start) for start in starts]
    if abs(size) < _SMALLEST:  # equal to within the rectangle, as the waves of equal layers far apart
        return [0.5 * (low + high)] * count
    for cut in _CUTS:
        if size.real > size.imag:
            middle = low.real + cut * size.real
            parts = [(low, complex(middle, high.imag)), (complex(middle, low.imag), high)]
        else:
            middle = low.imag + cut * size.imag
            parts = [(low, complex(high.real, middle)), (complex(low.real, middle), high)]
        try:
            boundaries = [_boundary(log_function, *part) for part in parts]
        except ArithmeticError:
            continue
        counts = [part_boundary.zero_count for part_boundary in boundaries]
        if sum(counts) == count and min(counts) >= 0:
            return [
                zero
                for part, part_boundary in zip(parts, boundaries, strict=True)
                for zero in _zeros(log_function, *part, part_boundary)
            ]
    raise ArithmeticError(f"no cut between {low:g} and {high:g} keeps clear of zeros")


def _search(
    log_function: LogFunction, starts: np.ndarray, low: complex, high: complex
) -> list[complex] | None:
    """Return the zeros that Newton's method leads to, each divided out for the next; None if one leaves."""
    size = abs(high - low)
    slack = 1e-9 * size
    roots: list[complex] = []
    for start in starts:
        z, step = complex(start), complex(0.1 * size)
        for _ in range(_MOST_STEPS):
            offset = max(1e-3 * abs(step), 1e-3 * _ACCEPTED)
            points = np.array([z, z + offset])
            with np.errstate(divide="ignore", invalid="ignore"):  # on a zero that is known
                value, beside = log_function(points) - np.log(points[:, None] - np.array(roots)).sum(axis=1)
            if value.real == -np.inf:
                step = 0j
                break
            if not abs((beside - value).real) < _MOST_RATIO:
                return None
            ratio = np.exp(beside - value)
            if ratio == 1.0:
                return None
            step = complex(offset / (ratio - 1.0))
            z -= step
            if abs(step) < _CONVERGED:
                break
            if not abs(z - start) < size:
                return None
        inside = (
            low.real - slack < z.real < high.real + slack and low.imag - slack < z.imag < high.imag + slack
        )
        if not inside or abs(step) > _ACCEPTED:
            return None
        roots.append(z)
    return roots
