"""Canonical frequencies: nested, shared edges, exact interpolation of polynomials."""

import numpy as np
import pytest

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_interpolation import interpolate


def test_edges_meet_and_are_those_of_one_third_octaves():
    assert blocks.edges(0)[0] == pytest.approx(10**0.05)
    for block in range(-3, 6):
        assert blocks.edges(block)[1] == pytest.approx(blocks.edges(block + 1)[0], rel=1e-14)


@pytest.mark.parametrize("level", [0, 1, 3])
@pytest.mark.parametrize("block", [-3, 0, 4])
def test_levels_are_nested(block, level):
    k = blocks.indices(block, level)
    np.testing.assert_allclose(blocks.frequency(level, k), blocks.frequency(level + 1, 2 * k), rtol=1e-14)
    inside = blocks.frequency(level, k)[blocks.HALO : -blocks.HALO]
    np.testing.assert_allclose(inside[[0, -1]], blocks.edges(block), rtol=1e-13)
    halfway = blocks.halfway_indices(block, level, 5)
    assert np.all(halfway % 2 == 1)
    low, high = blocks.edges(block)
    assert np.all(
        (blocks.frequency(level + 1, halfway) > low) & (blocks.frequency(level + 1, halfway) < high)
    )


@pytest.mark.parametrize("level", [0, 2])
def test_interpolation_is_exact_for_seventh_degree_in_ln_f(level):
    tabulated = blocks.frequency(level, blocks.indices(1, level))
    low, high = blocks.edges(1)
    f = np.concatenate([np.geomspace(low, high, 57), tabulated[blocks.HALO : -blocks.HALO]])
    f = np.clip(f, low, high)

    def polynomial(x):
        t = np.log10(x) - 0.75
        return np.stack([1.0 + t - 3.0 * t**5 + 2j * t**7, t**6 + 0j * t], axis=1)

    value = interpolate(1, level, f, polynomial(tabulated))
    np.testing.assert_allclose(value, polynomial(f), rtol=0, atol=1e-11)


def test_every_frequency_has_a_block():
    f = np.array([0.001, 0.5, 1.0, 10**0.05, 3.0, 20.0, 1e4])
    which = blocks.nearest_block(f, range(-3, 4))
    np.testing.assert_array_equal(which, [-3, -1, -1, 0, 0, 2, 3])
    for each, block in zip(f[1:-1], which[1:-1], strict=True):
        low, high = blocks.edges(int(block))
        assert low * (1.0 - 1e-9) <= each <= high * (1.0 + 1e-9)
    assert blocks.edges(blocks.up_to(100.0)[-1])[1] >= 100.0
    assert blocks.edges(blocks.up_to(100.0)[-1])[0] < 100.0
    assert blocks.up_to(100.0)[0] == blocks.LOWEST


@pytest.mark.parametrize("level", [0, 2])
def test_blocks_without_halos_hold_every_frequency_once(level):
    f = [
        blocks.frequency(level, blocks.indices(block, level)[blocks.inside(block, level)]) for block in (0, 1)
    ]
    lower, upper = blocks.edges(0)[0], blocks.edges(1)[1]
    assert f[0][0] == pytest.approx(lower)
    assert f[0][-1] < f[1][0] == pytest.approx(blocks.edges(0)[1])
    np.testing.assert_allclose(np.diff(np.log10([*f[0], *f[1], upper])), 0.02 / 2**level)


def test_frequencies_beyond_the_tables_are_a_fault():
    blocks.check_coverage(np.array([1.0, blocks.edges(1)[1]]), range(-1, 2))
    blocks.check_coverage(np.array([1e-4, 1.0]), range(blocks.LOWEST, 2))  # static below the lowest block
    blocks.check_coverage(np.array([]), range(2))
    for beyond in (blocks.edges(1)[1] * 1.001, blocks.edges(-1)[0] * 0.999):
        with pytest.raises(ValueError, match="tables reach from"):
            blocks.check_coverage(np.array([beyond]), range(-1, 2))
