"""What a worker keeps at hand of results."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from sweep.storage.cache import UNMEASURED, Cache, Latest

NUMBERS = 1000
BYTES = 8 * NUMBERS


@dataclass(frozen=True, eq=False)
class Shared:
    array: np.ndarray

    @cached_property
    def derived(self) -> dict[str, np.ndarray]:
        return {}


@dataclass(frozen=True)
class Result:
    own: np.ndarray
    shared: Shared
    name: str = "a"

    @cached_property
    def derived(self) -> dict[str, tuple[int, np.ndarray]]:
        return {}


@pytest.fixture
def shared():
    return Shared(np.zeros(NUMBERS))


def filled(cache, count, shared, start=0):
    results = {("home", str(n)): Result(np.zeros(NUMBERS), shared) for n in range(start, start + count)}
    for key, result in results.items():
        cache.put(key, result)
    return results


def held(cache, results):
    return [key for key, result in results.items() if cache.get(key) is result]


def test_what_results_share_counts_once(shared):
    cache = Cache(11 * BYTES)
    results = filled(cache, 10, shared)
    assert held(cache, results) == list(results)


def test_what_results_share_counts_as_long_as_one_of_them_is_held(shared):
    cache = Cache(20 * BYTES)
    first = filled(cache, 4, Shared(np.zeros(8 * NUMBERS)))
    assert held(cache, first) == list(first)
    later = filled(cache, 12, shared, start=4)
    assert held(cache, later) == list(later)
    assert held(cache, first) == []
    more = filled(cache, 5, shared, start=16)
    assert held(cache, later | more) == [*later, *more]


def test_what_is_derived_from_what_results_share_counts_once(shared):
    cache = Cache(40 * BYTES)
    results = filled(cache, 4, shared)
    shared.derived["forces"] = np.zeros(18 * NUMBERS)
    results |= filled(cache, UNMEASURED, shared, start=4)
    assert held(cache, results) == list(results)
    shared.derived["more forces"] = np.zeros(18 * NUMBERS)
    filled(cache, UNMEASURED, Shared(np.zeros(0)), start=20)
    assert held(cache, results) == []


def test_what_was_used_last_is_held(shared):
    cache = Cache(20 * BYTES)
    first = filled(cache, 15, shared)
    cache.get(("home", "0"))
    filled(cache, 10, shared, start=15)
    assert ("home", "0") in held(cache, first)
    assert ("home", "1") not in held(cache, first)


def test_what_is_derived_from_a_result_and_kept_with_it_counts(shared):
    cache = Cache(40 * BYTES)
    results = filled(cache, 8, shared)
    for result in results.values():
        result.derived["squares"] = (1, np.zeros(4 * NUMBERS))
    later = filled(cache, UNMEASURED, shared, start=8)
    alive = [*held(cache, results), *held(cache, later)]
    assert 20 <= sum(5 if key in results else 1 for key in alive) <= 40
    assert held(cache, later) == list(later)


def test_a_result_beyond_the_limit_is_not_held_and_all_can_be_let_go(shared):
    cache = Cache(5 * BYTES)
    cache.put(("home", "large"), Result(np.zeros(9 * NUMBERS), shared))
    assert cache.get(("home", "large")) is None
    results = filled(cache, 3, shared)
    assert held(cache, results) == list(results)
    cache.clear()
    assert held(cache, results) == []


def test_what_was_derived_and_is_gone_counts_no_longer(shared):
    cache = Cache(40 * BYTES)
    results = filled(cache, 4, shared)
    for result in results.values():
        result.derived["squares"] = (1, np.zeros(3 * NUMBERS))
    results |= filled(cache, UNMEASURED, shared, start=4)
    for result in results.values():
        result.derived.clear()
    results |= filled(cache, UNMEASURED, shared, start=20)
    assert held(cache, results) == list(results)


def test_a_result_that_was_let_go_between_is_measured_when_it_is_used_again(shared):
    cache = Cache(40 * BYTES)
    filled(cache, 4, shared)
    filled(cache, UNMEASURED, shared, start=4)
    used = [cache.get(("home", str(n))) for n in range(4)]
    for result in used:
        result.derived["squares"] = (1, np.zeros(7 * NUMBERS))
    del used, result
    later = filled(cache, UNMEASURED, shared, start=20)
    assert cache.get(("home", "4")) is None
    assert held(cache, later) == list(later)


def test_of_small_things_those_set_last_are_kept():
    latest = Latest(2)
    for key in "abacb":
        latest[key] = key
    assert latest == {"c": "c", "b": "b"}
    latest["c"] = latest["d"] = "d"
    assert list(latest) == ["c", "d"]
