"""The straight-line exponential, sine and cosine against numpy, over the ranges that they state."""

import numba
import numpy as np

from railvib.vector_math import cos_sin, exp


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
