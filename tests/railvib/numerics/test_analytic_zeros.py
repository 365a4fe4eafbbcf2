"""Zeros of analytic functions that are known."""

import numpy as np
import pytest

from railvib.numerics.analytic_zeros import zeros


def logarithm(function):
    def log_function(z):
        with np.errstate(divide="ignore"):
            return np.log(function(z))

    return log_function


def polynomial(roots):
    return logarithm(lambda z: np.prod(z[:, None] - np.asarray(roots), axis=1))


def ordered(z):
    return np.array(sorted(z, key=lambda each: (round(each.real, 6), each.imag)))


def test_sine():
    found = zeros(logarithm(np.sin), -10.0 - 1.0j, 10.5 + 1.0j)
    np.testing.assert_allclose(ordered(found), np.pi * np.arange(-3, 4), atol=1e-12)


def test_none():
    assert zeros(logarithm(lambda z: np.exp(5.0 * z)), -3.0 - 1.0j, 3.0 + 1.0j).size == 0


def test_only_those_inside():
    found = zeros(polynomial([0.3 + 0.2j, 0.9 - 0.4j, 1.4, -0.2j]), 0.1 - 1.0j, 1.1 + 1.0j)
    np.testing.assert_allclose(ordered(found), [0.3 + 0.2j, 0.9 - 0.4j], atol=1e-12)


@pytest.mark.parametrize("gap", [1e-3, 1e-5, 1e-7])
def test_close_pair(gap):
    found = zeros(polynomial([0.4, 0.4 + gap, 0.7j]), -1.0 - 1.0j, 1.0 + 1.0j)
    np.testing.assert_allclose(ordered(found), [0.7j, 0.4, 0.4 + gap], atol=1e-8)


def test_double_zero_counts_twice():
    found = zeros(polynomial([0.4, 0.4]), -1.0 - 1.0j, 1.0 + 1.0j)
    np.testing.assert_allclose(found, [0.4, 0.4], atol=1e-5)


@pytest.mark.parametrize("gap", [1e-6, 1e-10, 0.0])
def test_a_cluster_counts_as_often_as_it_has_zeros(gap):
    cluster = 0.4 + gap * np.arange(5)
    found = zeros(polynomial([*cluster, 0.7j]), -1.0 - 1.0j, 1.0 + 1.0j)
    np.testing.assert_allclose(ordered(found), [0.7j, *cluster], atol=1e-4)


@pytest.mark.parametrize("seed", range(10))
def test_many(seed):
    rng = np.random.default_rng(seed)
    expected = rng.uniform(-2.0, 2.0, 60) + 1j * rng.uniform(-0.5, 0.5, 60)
    found = zeros(polynomial(expected), -2.05 - 0.55j, 2.05 + 0.55j)
    np.testing.assert_allclose(ordered(found), ordered(expected), atol=1e-10)


def test_beyond_the_range_of_numbers():
    """cosh of hundreds of thousands, by its logarithm."""

    def log_function(z):
        w = 1e5 * z
        return np.where(w.real > 0.0, w, -w) + np.log1p(np.exp(np.where(w.real > 0.0, -2.0, 2.0) * w))

    found = zeros(log_function, -0.5 - 1.03e-4j, 0.5 + 1.03e-4j)
    np.testing.assert_allclose(ordered(found), np.pi / 2e5 * np.arange(-5, 6, 2) * 1j, atol=1e-12)


def test_zero_on_the_edge():
    with pytest.raises(ArithmeticError, match="edge"):
        zeros(polynomial([1.0 + 0.123j]), -1.0 - 1.0j, 1.0 + 1.0j)
