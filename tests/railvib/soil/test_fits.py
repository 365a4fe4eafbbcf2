"""The fits of a block: when they are made, from what, and that the order of asking does not matter."""

import pytest

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.ground import Ground
from railvib.soil.fits import BlockFits, GroundFits, warm_or_cold
from railvib.soil.rational_fit import fit_flexibility

BLOCK = 1


def first():
    return int(blocks.indices(BLOCK, 0)[0])


def test_the_order_of_asking_does_not_matter(greby):
    k = first()
    places = [(0, k), (0, k + 2), (1, 2 * k + 5)]
    forwards, backwards = GroundFits(greby, BLOCK, 1e-9), GroundFits(greby, BLOCK, 1e-9)
    ascending = [forwards.at(*place) for place in places]
    descending = [backwards.at(*place) for place in reversed(places)]
    for one, other in zip(ascending, reversed(descending), strict=True):
        assert (one.pole == other.pole).all()
        assert (one.residue == other.residue).all()


def test_a_frequency_of_two_levels_is_fitted_once(greby):
    fits = GroundFits(greby, BLOCK, 1e-9)
    assert fits.at(0, first()) is fits.at(2, 4 * first())


def test_neighbours_start_from_the_one_below(greby):
    starts = []

    def fit(frequency, start):
        starts.append((frequency, start))
        return fit_flexibility(greby, frequency, 1e-6, start)

    fits = BlockFits(greby, BLOCK, fit)
    k = first()
    fits.at(1, 2 * k + 3)
    assert [frequency for frequency, _ in starts] == [
        float(blocks.frequency(0, k)),
        float(blocks.frequency(0, k + 1)),
        float(blocks.frequency(1, 2 * k + 3)),
    ]
    assert starts[0][1] is None
    assert starts[1][1] is fits.at(0, k).start
    assert starts[2][1] is fits.at(0, k + 1).start


def test_a_half_space_is_fitted_once_per_block(horstwalde):
    ground = Ground(layers=[horstwalde.layers[-1]])
    with cost.collect() as spent:
        fits = GroundFits(ground, BLOCK, 1e-9)
        fits.at(0, first() + 7)
        fits.at(1, 2 * first() + 3)
    assert sum(each.kernel_calls for each in spent) == 1


class Fit:
    def __init__(self, error):
        self.error = error


@pytest.mark.parametrize(
    ("warm", "cold", "expected"), [(1.0, 0.0, 1.0), (3.0, 2.5, 2.5), (3.0, 4.0, 3.0)], ids=str
)
def test_a_cold_start_is_tried_where_a_warm_one_misses(warm, cold, expected):
    result = warm_or_cold("fit", lambda start: Fit(cold if start is None else warm), "neighbour", 2.0)
    assert result.error == expected


def test_nothing_else_is_tried_after_a_cold_start():
    calls = []
    warm_or_cold("fit", lambda start: calls.append(start) or Fit(5.0), None, 2.0)
    assert calls == [None]
