"""Caches of a worker: results up to a number of bytes, small entries up to a count."""

from collections import OrderedDict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

Key = TypeVar("Key")
Value = TypeVar("Value")

CACHE_BYTES = 128 * 2**20
"""Memory for results that a worker has stored or read, kept for its next tasks."""
UNMEASURED = 16
UNMEASURED_SHARE = 0.125
"""Number of new results, and their share, after which all are measured again: derived data grow."""
ROOM = 0.9
"""Share of the cache that stays filled when it overflows."""


class Latest(dict[Key, Value]):
    """Dictionary of the latest entries, up to a number of them."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def __setitem__(self, key: Key, value: Value) -> None:
        """Set an entry, and drop the oldest one if there are too many."""
        self.pop(key, None)  # an entry set again becomes the latest
        super().__setitem__(key, value)
        if len(self) > self._most:
            del self[next(iter(self))]


@dataclass
class _Held:
    """A result or shared part, with the size of its arrays when last measured."""

    result: Any
    nbytes: int = 0
    holders: int = 0

    def measure(self) -> int:
        """Measure it again; return by how many bytes it has grown."""
        nbytes = _nbytes(vars(self.result).values())
        grown = nbytes - self.nbytes
        self.nbytes = nbytes
        return grown


class Cache:
    """The results used last, up to a number of bytes.

    Shared parts count once. Data derived from a result and kept with it count as well: from time to time all
    entries are measured again.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._nbytes = 0
        self._unmeasured = 0
        self._results: OrderedDict[tuple[str, str], _Held] = OrderedDict()
        self._shared: dict[Any, _Held] = {}

    def get(self, key: tuple[str, str]) -> Any:
        """Return a result, or None if it is not cached."""
        entry = self._results.get(key)
        if entry is None:
            return None
        self._results.move_to_end(key)
        return entry.result

    def put(self, key: tuple[str, str], result: Any) -> None:
        """Cache a result, and drop those not used for longest."""
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
        """Drop all entries."""
        self._results.clear()
        self._shared.clear()
        self._nbytes = self._unmeasured = 0

    def _measure(self) -> None:
        """Measure all entries; on overflow make room for several more."""
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
    """Yield the shared parts of a result: the dataclasses to which it refers."""
    for value in vars(result).values():
        if hasattr(value, "__dataclass_fields__"):
            yield value
            yield from _shared_parts(value)


def _nbytes(values: Iterable[Any]) -> int:
    """Return the bytes of arrays among values, including those in dictionaries and tuples."""
    total = 0
    for value in values:
        if isinstance(value, np.ndarray):
            total += value.nbytes
        elif isinstance(value, dict):
            total += _nbytes(value.values())
        elif isinstance(value, tuple) and value and not isinstance(value[0], float):
            total += _nbytes(value)
    return total
