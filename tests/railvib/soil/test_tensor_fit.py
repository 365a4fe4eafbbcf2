"""The rational fit of the flexibility tensor, judged where it has not been fitted."""

import numpy as np
import pytest

from railvib.parameters.ground import Ground
from railvib.soil import tensor_fit
from railvib.soil._kernels.layers import RR, RZ, TT, ZZ, surface_components
from railvib.soil.tensor_fit import fit_tensor
from tests.physics.judges import random_ground


def largest_error(ground, frequency, fit, last):
    r = np.geomspace(1e-3, last, 1237)
    q = surface_components(r, 2.0 * np.pi * frequency, ground.stack(), ground.base == "rigid")
    zz, rr, tt, d, c = fit.parts(r)
    return max(
        abs(zz / q[ZZ] - 1.0).max(),
        abs(rr / q[RR] - 1.0).max(),
        abs(tt / q[TT] - 1.0).max(),
        abs((r**2 * d - q[RR] + q[TT]) / q[TT]).max(),
        abs((r * c - q[RZ]) / q[ZZ]).max(),
    )


def random_cases(count):
    rng = np.random.default_rng(11)
    for number in range(count):
        ground = random_ground(rng, 5, "rigid" if number % 5 == 0 else "half-space")
        yield ground, float(np.exp(rng.uniform(np.log(0.5), np.log(250.0))))


def test_random_grounds():
    for ground, frequency in random_cases(40):
        fit = fit_tensor(ground, frequency, largest=3000.0)
        assert fit.error < 1e-6
        assert largest_error(ground, frequency, fit, 3000.0) < 3.0 * max(fit.error, 1e-8)


def test_rounding_of_the_tensor_does_not_spoil_the_fit(monkeypatch):
    """Where several singular values are at the level of rounding, one vector of an SVD may have entries that
    are zero, and of the last of these grounds every other fit failed.
    """
    exact = tensor_fit.surface_components
    rng = np.random.default_rng(1)

    def rounded(*arguments):
        q = exact(*arguments)
        return q * (1.0 + 1e-15 * rng.uniform(-1.0, 1.0, q.shape))

    monkeypatch.setattr(tensor_fit, "surface_components", rounded)
    cases = list(random_cases(38))
    for ground, frequency in cases + 12 * cases[-1:]:
        assert fit_tensor(ground, frequency, largest=3000.0).error < 1e-6


def test_start_from_a_neighbour(greby):
    cold = fit_tensor(greby, 20.0, largest=3000.0)
    warm = fit_tensor(greby, 20.5, start=cold.start, largest=3000.0)
    assert largest_error(greby, 20.5, warm, 3000.0) < 1e-7


@pytest.mark.parametrize("ratio", [1.0, 3.7])
def test_half_space_needs_one_fit(horstwalde, ratio):
    fit = fit_tensor(horstwalde, 10.0, largest=3000.0).scale(ratio)
    assert largest_error(horstwalde, 10.0 * ratio, fit, 3000.0) < 1e-7


def test_range_follows_what_is_asked(greby):
    thin = Ground(layers=greby.layers)
    near, far = fit_tensor(thin, 20.0), fit_tensor(thin, 20.0, largest=5000.0)
    assert largest_error(thin, 20.0, near, 290.0) < 1e-6
    assert largest_error(thin, 20.0, far, 5000.0) < 1e-6
    assert largest_error(thin, 20.0, near, 5000.0) > 1e-3
