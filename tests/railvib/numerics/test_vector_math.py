"""The straight-line exponential, logarithm, sine and cosine against numpy, over their stated ranges."""

import numba
import numpy as np

from railvib.numerics.vector_math import cos_sin, exp, exp2_cispi, log, phasors, rough_log2


@numba.njit
def _all(x, y):
    e, c, s = np.empty(x.size), np.empty(y.size), np.empty(y.size)
    for i in range(x.size):
        e[i] = exp(x[i])
    for i in range(y.size):
        c[i], s[i] = cos_sin(y[i])
    return e, c, s


def test_within_two_units_in_the_last_place():
    rng = np.random.default_rng(1)
    x = np.concatenate([rng.uniform(-699.0, 699.0, 20000), rng.normal(size=20000), [0.0, -0.0, 1e-300]])
    y = np.concatenate(
        [rng.uniform(-1e6, 1e6, 20000), rng.normal(size=20000) * 4.0, np.pi / 4.0 * np.arange(-64, 65)]
    )
    e, c, s = _all(x, y)
    np.testing.assert_allclose(e, np.exp(x), rtol=6e-16)
    np.testing.assert_allclose(c, np.cos(y), rtol=0, atol=3e-16)
    np.testing.assert_allclose(s, np.sin(y), rtol=0, atol=3e-16)


@numba.njit
def _logarithms(x):
    out = np.empty(x.size)
    for i in range(x.size):
        out[i] = log(x[i])
    return out


def test_logarithm():
    rng = np.random.default_rng(2)
    x = np.concatenate(
        [
            np.exp(rng.uniform(-700.0, 700.0, 20000)),
            np.exp(rng.normal(size=20000)),
            2.0 ** np.arange(-1000, 1000),
        ]
    )
    np.testing.assert_allclose(_logarithms(x), np.log(x), rtol=5e-16, atol=0)


@numba.njit
def _powers_turned(x, y):
    real, imag = np.empty(x.size), np.empty(x.size)
    for i in range(x.size):
        real[i], imag[i] = exp2_cispi(x[i], y[i])
    return real + 1j * imag


def test_powers_that_are_turned():
    rng = np.random.default_rng(3)
    x = np.concatenate([rng.uniform(-999.0, 999.0, 20000), rng.normal(size=20000), np.arange(-64, 65) / 4.0])
    y = np.concatenate([rng.uniform(-1e6, 1e6, 20000), rng.normal(size=20000), np.arange(-64, 65) / 4.0])
    left = y - 2.0 * np.round(0.5 * y)  # so the multiple of π is rounded where it is small
    expected = np.exp2(x) * np.exp(1j * np.pi * left)
    error = np.abs(_powers_turned(x, y) - expected) / np.abs(expected)
    assert error.max() < 1.2e-15
    cut = _powers_turned(np.array([-1e6, -1000.0]), np.array([0.3, 0.3]))
    assert cut[0] == cut[1] != 0.0


@numba.njit
def _rough_logarithms(x):
    out = np.empty(x.size)
    for i in range(x.size):
        out[i] = rough_log2(x[i])
    return out


def test_rough_logarithm():
    x = np.concatenate([np.geomspace(1e-300, 1e300, 20001), 2.0 ** np.arange(-1000, 1000)])
    short = np.log2(x) - _rough_logarithms(x)
    assert -1e-12 < short.min() <= short.max() < 0.09


def test_turned():
    angle = np.linspace(-2e4, 2e4, 60_000).reshape(3, -1)
    np.testing.assert_allclose(phasors(angle), np.exp(1j * angle), rtol=0, atol=4e-16)
