"""What a worker keeps at hand: results within a number of bytes, and small things by their number."""

from collections import OrderedDict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

Key = TypeVar("Key")
Value = TypeVar("Value")

CACHE_BYTES = 128 * 2**20
"""What a worker keeps of the results that it has stored or read, for the tasks that follow."""
UNMEASURED = 16
UNMEASURED_SHARE = 0.125
"""Results, and share of those held, that are added before all are measured anew, as what is derived grows."""
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


@dataclass
class _Held:
    """A result, or what some results share, and the bytes of its arrays when it was measured last."""

    result: Any
    nbytes: int = 0
    holders: int = 0

    def measure(self) -> int:
        """Return how many bytes it has grown by."""
        nbytes = _nbytes(vars(self.result).values())
        grown = nbytes - self.nbytes
        self.nbytes = nbytes
        return grown


class Cache:
    """The results used last, up to a number of bytes.

    What some of them share counts once. What has been derived from a result and is kept with it counts as
    well: all are measured anew after some further results.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._nbytes = 0
        self._unmeasured = 0
        self._results: OrderedDict[tuple[str, str], _Held] = OrderedDict()
        self._shared: dict[Any, _Held] = {}

    def get(self, key: tuple[str, str]) -> Any:
        """Return a result, or None where it is not held."""
        entry = self._results.get(key)
        if entry is None:
            return None
        self._results.move_to_end(key)
        return entry.result

    def put(self, key: tuple[str, str], result: Any) -> None:
        """Hold a result, and let go of those not used for longest."""
        if key in self._results:
            return
        entry = self._results[key] = _Held(result)
        self._nbytes += entry.measure()
        for part in _shared_parts(result):
            if part not in self._shared:
                self._shared[part] = _Held(part)
                self._nbytes += self._shared[part].measure()
            self._shared[part].holders += 1
        self._unmeasured += 1
        if self._nbytes > self._limit or self._unmeasured >= max(
            UNMEASURED, UNMEASURED_SHARE * len(self._results)
        ):
            self._measure()

    def clear(self) -> None:
        """Let go of all."""
        self._results.clear()
        self._shared.clear()
        self._nbytes = self._unmeasured = 0

    def _measure(self) -> None:
        """Find what has grown, and make so much room that it lasts for some results."""
        self._unmeasured = 0
        self._nbytes += sum(entry.measure() for entry in (*self._results.values(), *self._shared.values()))
        if self._nbytes <= self._limit:
            return
        while self._results and self._nbytes > ROOM * self._limit:
            _key, entry = self._results.popitem(last=False)
            self._nbytes -= entry.nbytes
            for part in _shared_parts(entry.result):
                self._shared[part].holders -= 1
                if not self._shared[part].holders:
                    self._nbytes -= self._shared.pop(part).nbytes


def _shared_parts(result: Any) -> Iterator[Any]:
    """Yield the dataclasses to which a result refers: what it shares with others."""
    for value in vars(result).values():
        if hasattr(value, "__dataclass_fields__"):
            yield value
            yield from _shared_parts(value)


def _nbytes(values: Iterable[Any]) -> int:
    """Return the bytes of the arrays among values, and in dictionaries and tuples."""
    total = 0
    for value in values:
        if isinstance(value, np.ndarray):
            total += value.nbytes
        elif isinstance(value, dict):
            total += _nbytes(value.values())
        elif isinstance(value, tuple) and value and not isinstance(value[0], float):
            total += _nbytes(value)
    return total
