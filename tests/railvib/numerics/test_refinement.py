"""Searching levels and halving panels, on functions whose answers are known."""

import numpy as np
import pytest

from railvib.numerics.refinement import Panels, divide, halve, search_level, search_levels
from railvib.numerics.wavenumber_panels import WEIGHT, nodes_between, series_tails

ERRORS = {"rough": 1.0, "smooth": 1e-3, "hopeless": 1e9}
"""Of items at level 0; each level divides them by ten."""


class Tabulation:
    """Tabulates items, and remembers which it was asked for."""

    def __init__(self):
        self.asked = []
        self.required = []

    def __call__(self, level, items):
        self.asked.append((level, sorted(items)))

        def check(item, required):
            if required:
                self.required.append((level, item))
            error = ERRORS[item] * 10.0**-level
            return f"{item} at {level}", error <= 1e-3

        return check


def searched(start, **options):
    tabulation = Tabulation()
    batches = list(search_levels(start, tabulation, **options))
    return {item: result for batch in batches for item, result in batch.items()}, batches, tabulation


def test_each_item_takes_the_first_level_that_passes():
    found, batches, tabulation = searched(dict.fromkeys(ERRORS, 0), last=5)
    assert found == {
        "smooth": (0, "smooth at 0"),
        "rough": (3, "rough at 3"),
        "hopeless": (5, "hopeless at 5"),
    }
    assert [sorted(batch) for batch in batches] == [["smooth"], ["rough"], ["hopeless"]]
    assert tabulation.asked == [
        (0, ["hopeless", "rough", "smooth"]),
        *((level, ["hopeless", "rough"]) for level in (1, 2, 3)),
        *((level, ["hopeless"]) for level in (4, 5)),
    ]
    assert tabulation.required == [(5, "hopeless")]


def test_items_may_start_at_different_levels():
    found, _batches, tabulation = searched({"rough": 2, "smooth": 1, "hopeless": 7}, last=5)
    assert {item: level for item, (level, _) in found.items()} == {"rough": 3, "smooth": 1, "hopeless": 7}
    assert tabulation.asked == [(1, ["smooth"]), (2, ["rough"]), (3, ["rough"]), (7, ["hopeless"])]


@pytest.mark.parametrize("beyond", [0, 1, 2])
def test_levels_beyond_the_first_that_passes(beyond):
    found, _batches, tabulation = searched(dict.fromkeys(ERRORS, 0), last=4, beyond=beyond)
    assert {item: level - beyond for item, (level, _) in found.items()} == {
        "smooth": 0,
        "rough": 3,
        "hopeless": 4,
    }
    # Once an item has passed, its results at finer levels are required.
    assert {item for level, item in tabulation.required if level < 4} == ({"smooth"} if beyond else set())


def test_one_item():
    def check(level, required):
        return 10.0**-level, required or level >= 2

    assert search_level(0, check) == (2, 1e-2)
    assert search_level(3, check) == (3, 1e-3)
    assert search_level(0, lambda level, required: (level, False), last=4) == (4, 4)


def peak(x):
    """A function that needs narrow panels near 0.3."""
    return 1e-2 / ((x - 0.3) ** 2 + 1e-4)


def test_panels_are_halved_where_they_do_not_resolve():
    counts = []

    def evaluate(panels):
        counts.append(panels.low.size)
        value = peak(nodes_between(panels.edges).reshape(panels.low.size, -1))
        return value, series_tails(value)[:, 0] > 1e-9

    parts = list(halve(Panels.between(np.array([0.0, 0.5, 1.0])), evaluate, 20))
    assert counts[0] == 2
    low, high = (np.concatenate([part[edge] for part, _value in parts]) for edge in (0, 1))
    value = np.concatenate([value for _part, value in parts])
    integral = ((value @ WEIGHT) * 0.5 * (high - low)).sum()
    assert integral == pytest.approx(np.arctan(70.0) + np.arctan(30.0), rel=1e-9)
    assert series_tails(value).max() <= 1e-9
    narrow = high - low < 0.02
    assert narrow.any()
    assert np.all(np.abs(low[narrow] - 0.3) < 0.1)
    order = np.argsort(low)
    assert low[order[0]] == 0.0
    np.testing.assert_array_equal(low[order[1:]], high[order[:-1]])  # no gaps, no overlaps


def test_panels_are_halved_no_more_often_than_allowed():
    calls = []

    def evaluate(panels):
        calls.append(panels.low.size)
        return panels.low, np.ones(panels.low.size, bool)

    parts = list(halve(Panels.between(np.array([0.0, 1.0, 3.0])), evaluate, 3))
    assert calls == [2, 4, 8, 16]
    assert [panels.low.size for panels, _ in parts] == [0, 0, 0, 16]
    panels, low = parts[-1]
    np.testing.assert_array_equal(low, panels.low)
    np.testing.assert_array_equal(np.sort(low), [*np.arange(8) / 8.0, *(1.0 + np.arange(8) / 4.0)])


def test_edges_stay_where_panels_are_divided():
    edge = np.array([0.0, 0.3, 1.0, 2.5])
    fine = divide(edge, 3)
    np.testing.assert_allclose(fine, [0.0, 0.1, 0.2, 0.3, 0.3 + 0.7 / 3, 0.3 + 1.4 / 3, 1.0, 1.5, 2.0, 2.5])
    np.testing.assert_array_equal(fine[::3], edge)
    np.testing.assert_array_equal(divide(edge, 1), edge)
