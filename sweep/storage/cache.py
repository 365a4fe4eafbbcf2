"""What a worker keeps at hand: results within a number of bytes, and small things by their number.

Only results in use are measured again and again: all others cannot grow.
"""

import sys
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, TypeVar

import numpy as np

Key = TypeVar("Key")
Value = TypeVar("Value")

CACHE_BYTES = 128 * 2**20
"""What a worker keeps of the results that it has stored or read, for the tasks that follow."""
UNMEASURED = 16
"""Results that are held before those in use are measured anew, as what is derived from them grows."""
ROOM = 0.9
"""Share of the cache that is left in use when it is full."""


class Latest(dict[Key, Value]):
    """The entries that were set last, up to a number of them."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def __setitem__(self, key: Key, value: Value) -> None:
        """Set an entry, and drop the one set longest ago where there are too many."""
        self.pop(key, None)  # what is set again goes last
        super().__setitem__(key, value)
        if len(self) > self._most:
            del self[next(iter(self))]


_Sized = tuple[int, int]
"""An array by its address, and its size in bytes."""


@dataclass
class _Held:
    """A result, its own arrays, and those that had been derived from it when it was measured last."""

    result: Any
    own: list[_Sized]
    derived: list[_Sized] = field(default_factory=list)

    def measure(self) -> list[_Sized]:
        """Return the arrays derived from the result that are kept with it, behind its fields."""
        return _sized(islice(vars(self.result).values(), _field_count(self.result), None))

    def used_elsewhere(self) -> bool:
        """Return whether somebody else has the result, and may derive more from it."""
        return sys.getrefcount(self.result) > 2  # this one's, and the argument of the call


class Cache:
    """The results used last, up to a number of bytes.

    An array that some have in common counts once, and what has been derived from a result and is kept with it
    counts as well: it is measured some results later, and again as long as somebody uses the result.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._held = 0
        self._unmeasured = 0
        self._results: OrderedDict[tuple[str, str], _Held] = OrderedDict()
        self._used: set[tuple[str, str]] = set()
        # An array that was derived and is gone counts until its result is measured: what has taken its
        # place in memory must not pass for it, unless it is as large.
        self._holders: dict[_Sized, int] = {}

    def get(self, key: tuple[str, str]) -> Any:
        """Return a result, or None where it is not held."""
        held = self._results.get(key)
        if held is None:
            return None
        self._results.move_to_end(key)
        self._used.add(key)
        return held.result

    def put(self, key: tuple[str, str], result: Any) -> None:
        """Hold a result, and let go of those not used for longest."""
        if key in self._results:
            return
        own = _sized(islice(vars(result).values(), _field_count(result)))
        self._results[key] = _Held(result, own)
        self._used.add(key)
        self._take(own)
        self._unmeasured += 1
        if self._held > self._limit or self._unmeasured >= UNMEASURED:
            self._measure()

    def clear(self) -> None:
        """Let go of all."""
        self._results.clear()
        self._used.clear()
        self._holders.clear()
        self._held = self._unmeasured = 0

    def _measure(self) -> None:
        """Find what has grown, and make so much room that it lasts for some results."""
        self._unmeasured = 0
        for key in list(self._used):
            held = self._results[key]
            self._release(held.derived)
            held.derived = held.measure()
            self._take(held.derived)
            if not held.used_elsewhere():
                self._used.remove(key)
        if self._held <= self._limit:
            return
        while self._results and self._held > ROOM * self._limit:
            key, held = self._results.popitem(last=False)
            self._used.discard(key)
            self._release(held.own)
            self._release(held.derived)

    def _take(self, arrays: Iterable[_Sized]) -> None:
        """Count arrays that one more result holds."""
        for array in arrays:
            holders = self._holders.get(array, 0) + 1
            self._holders[array] = holders
            if holders == 1:
                self._held += array[1]

    def _release(self, arrays: Iterable[_Sized]) -> None:
        """Count arrays that one result less holds."""
        for array in arrays:
            holders = self._holders[array] - 1
            if holders:
                self._holders[array] = holders
            else:
                del self._holders[array]
                self._held -= array[1]


def _field_count(result: Any) -> int:
    # As many as `dataclasses.fields` returns of results, which it looks for among them each time.
    return len(result.__dataclass_fields__)


def _sized(values: Iterable[Any]) -> list[_Sized]:
    """Return the arrays among values, and in dictionaries and tuples."""
    found: list[_Sized] = []
    for each in values:
        if isinstance(each, np.ndarray):
            found.append((id(each), each.nbytes))
        elif isinstance(each, dict):
            found += _sized(each.values())
        elif isinstance(each, tuple) and each and not isinstance(each[0], float):
            found += _sized(each)
    return found
