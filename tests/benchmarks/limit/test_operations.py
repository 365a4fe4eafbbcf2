"""Counted kernels give what the compiled ones give, and their counts are those of known formulas."""

import numpy as np
import pytest

from benchmarks.limit.counting import Count
from benchmarks.limit.operations import count_operations
from benchmarks.peers.fourier_grid import OFFSETS
from railvib.numerics.vector_math import LANES, reciprocal
from railvib.soil._kernels.layers import surface_flexibilities
from railvib.soil._kernels.strip import strip_compliances
from railvib.soil.rational_fit import fit_flexibility


def test_a_reciprocal():
    # |z|² takes an addition and two multiplications; a division; and two products with it.
    expected = Count(additions=1, multiplications=4, divisions=1)
    value, count = count_operations(reciprocal, (2.0 + 1.0j,))
    assert vars(count) == vars(expected)
    assert count.total == 6.0
    assert value == pytest.approx(1.0 / (2.0 + 1.0j))


def test_the_flexibility(greby):
    r = np.geomspace(0.1, 5.0, LANES)
    values, count = count_operations(surface_flexibilities, (r, 60.0, greby.stack(), False), plain=(3,))
    np.testing.assert_allclose(values, surface_flexibilities(r, 60.0, greby.stack(), False), rtol=1e-12)
    # Two layers and a half-space, each with roots of p and s: a complex root takes two.
    assert count.per(LANES).roots == 3 * 2 * 2


def test_the_strip(greby):
    fit = fit_flexibility(greby, 20.0, 1e-10)
    beta = np.linspace(0.0, 3.0, 5)
    arguments = (beta, fit.pole, fit.residue, fit.constant, 1.6, OFFSETS)
    parts, count = count_operations(strip_compliances, arguments, STRETCH=1)
    for compiled, interpreted in zip(strip_compliances(*arguments), parts, strict=True):
        np.testing.assert_allclose(interpreted, compiled, rtol=1e-10, atol=1e-12 * abs(compiled).max())
    assert count.roots == 2 * beta.size * fit.pole.size
