"""Searching levels and halving panels, on functions whose answers are known."""

import numpy as np
import pytest

from railvib.numerics.refinement import Panels, divide, halve, search_level, search_levels
from railvib.numerics.wavenumber_panels import WEIGHT, unresolved

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


def peaks(x, owner):
    """Two functions, of which the second needs narrow panels near 0.3."""
    return np.where(owner == 0, np.cos(x), 1e-2 / ((x - 0.3) ** 2 + 1e-4))


def test_panels_are_halved_where_they_do_not_resolve():
    edge = np.array([0.0, 0.5, 1.0])
    first = Panels(np.tile(edge[:-1], 2), np.tile(np.diff(edge), 2), np.array([0, 0, 1, 1]))
    counts = []

    def evaluate(panels):
        counts.append(panels.low.size)
        value = peaks(panels.nodes, panels.owner[:, None])
        return value, unresolved(value)[:, 0] > 1e-9

    panels, value = halve(first, evaluate, 20)
    assert counts[0] == 4
    assert panels.low.size == value.shape[0]
    assert np.count_nonzero(panels.owner == 0) == 2
    integral = (value @ WEIGHT) * 0.5 * panels.width
    assert integral[panels.owner == 0].sum() == pytest.approx(np.sin(1.0), rel=1e-12)
    exact = np.arctan(70.0) + np.arctan(30.0)
    assert integral[panels.owner == 1].sum() == pytest.approx(exact, rel=1e-9)
    narrow = panels.select(panels.width < 0.02)
    assert np.all(np.abs(narrow.centre - 0.3) < 0.1)
    for owner in (0, 1):
        starts = np.sort(panels.low[panels.owner == owner])
        assert starts[0] == 0.0
        np.testing.assert_allclose(
            np.append(starts[1:], 1.0), np.sort((panels.low + panels.width)[panels.owner == owner])
        )


def test_panels_are_halved_no_more_often_than_allowed():
    calls = []

    def evaluate(panels):
        calls.append(panels.low.size)
        return panels.low, np.ones(panels.low.size, bool)

    panels, low = halve(Panels.between(np.array([0.0, 1.0, 3.0])), evaluate, 3)
    assert calls == [2, 4, 8, 16]
    np.testing.assert_array_equal(low, panels.low)
    np.testing.assert_array_equal(np.sort(low), [*np.arange(8) / 8.0, *(1.0 + np.arange(8) / 4.0)])


def test_halves_have_widths_equal_to_the_last_bit():
    panels = Panels.between(np.array([0.0, 0.1, 7.7, 60.3]))
    for _ in range(6):
        panels = panels.halves()
    np.testing.assert_array_equal(panels.width[::2], panels.width[1::2])
    assert panels.width.sum() == pytest.approx(60.3)


def test_edges_stay_where_panels_are_divided():
    edge = np.array([0.0, 0.3, 1.0, 2.5])
    fine = divide(edge, 3)
    np.testing.assert_allclose(fine, [0.0, 0.1, 0.2, 0.3, 0.3 + 0.7 / 3, 0.3 + 1.4 / 3, 1.0, 1.5, 2.0, 2.5])
    np.testing.assert_array_equal(fine[::3], edge)
    np.testing.assert_array_equal(divide(edge, 1), edge)
