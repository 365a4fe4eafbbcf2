"""Interpolation along frequency: exact on rows and for polynomials in ln f, and the same in every form."""

import numpy as np
import pytest

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.frequency_interpolation import combine_rows, interpolate, interpolate_blocks, stencils


def table_of(function, block, level):
    return function(blocks.frequency(level, blocks.indices(block, level)))


def polynomial(f):
    """Return a complex polynomial of the highest degree that a stencil holds, and a constant."""
    t = np.log10(f) - 0.75
    return np.stack([t ** (STENCIL - 1) - 2j * t**4, np.full(f.shape, 3.0 + 0j)], axis=1)


def resonance(f):
    """Return a resonance at 5 Hz with a damping ratio of 20 %."""
    return 1.0 / (1.0 - (f / 5.0) ** 2 + 0.4j * f / 5.0)[:, None]


def places(block, count=41):
    low, high = blocks.edges(block)
    return np.geomspace(low, high, count)[:-1]


@pytest.mark.parametrize("level", [0, 2])
def test_stencils_are_neighbouring_rows_whose_weights_add_up_to_one(level):
    f = places(1)
    first, weight = stencils(1, level, f)
    rows = blocks.indices(1, level).size
    assert np.all((first >= 0) & (first <= rows - STENCIL))
    position = blocks.position(1, level, f)
    assert np.all((first <= position) & (position <= first + STENCIL - 1))
    np.testing.assert_allclose(weight.sum(axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("level", [0, 1, 3])
def test_polynomials_in_the_logarithm_are_exact(level):
    f = places(1)
    interpolated = interpolate(1, level, f, table_of(polynomial, 1, level))
    np.testing.assert_allclose(interpolated, polynomial(f), rtol=0.0, atol=1e-12)


def test_a_row_is_returned_as_it_is():
    table = np.random.default_rng(3).normal(size=(blocks.indices(0, 0).size, 2)) + 1j
    inside = blocks.inside(0, 0)
    f = blocks.frequency(0, blocks.indices(0, 0)[inside])
    np.testing.assert_allclose(interpolate(0, 0, f, table), table[inside], rtol=1e-11)


def test_halving_the_step_gains_two_digits_and_more_on_a_resonance():
    """Ten points: the error falls by up to 2^10, as the step becomes small against the resonance."""
    f = places(1, 301)
    error = [np.abs(interpolate(1, n, f, table_of(resonance, 1, n)) - resonance(f)).max() for n in (0, 1, 2)]
    assert error[0] < 1e-3
    assert error[1] < error[0] / 200.0
    assert error[2] < error[1] / 500.0


def test_blocks_in_a_row_are_interpolated_as_each_alone():
    block, level = np.array([0, 1, 2]), np.array([1, 0, 2])
    tables = [table_of(resonance, *pair) for pair in zip(block.tolist(), level.tolist(), strict=True)]
    f = np.concatenate([places(b) for b in block.tolist()])
    together = interpolate_blocks(block, level, f, np.concatenate(tables))
    alone = [
        interpolate(b, n, places(b), table)
        for b, n, table in zip(block.tolist(), level.tolist(), tables, strict=True)
    ]
    np.testing.assert_array_equal(together, np.concatenate(alone))


def test_sums_of_rows_are_written_where_they_are_wanted():
    first, weight = stencils(1, 0, places(1))
    table = table_of(resonance, 1, 0)
    out = np.full((first.size, 1), np.nan + 0j)
    assert combine_rows(first, weight, table, out) is out
    np.testing.assert_array_equal(out, combine_rows(first, weight, table))
    rows = first[:, None] + np.arange(STENCIL)
    np.testing.assert_allclose(out, np.einsum("nm,nmj->nj", weight, table[rows]), rtol=1e-12)
