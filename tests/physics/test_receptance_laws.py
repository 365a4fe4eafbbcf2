"""Rail receptances, standing and moving, below and above the waves' speeds, against direct quadrature over
wavenumber.
"""

import numpy as np
import pytest

from railvib.errors import PlausibilityWarning
from railvib.parameters.ground import Ground, Layer
from railvib.plausibility import check_speed
from railvib.prediction import rail_receptance
from railvib.soil.surface_waves import surface_wave_speeds
from tests.physics.judges import random_ground, receptance_by_quadrature

DISTANCES = np.array([0.0, 2.7, -2.7, 16.3, -16.3])
SOILS = 4
"""Random soils, five points each; the last lies on a rigid base."""


def soil(seed: int) -> Ground:
    rng = np.random.default_rng([12, seed])
    ground = random_ground(rng, most_layers=3, base="rigid" if seed == 3 else "half-space")
    # Not below a loss factor of 0.05: the judge's cost grows with its inverse squared.
    layers = tuple(
        each.model_copy(update={"loss_factor": max(each.loss_factor, 0.05)}) for each in ground.layers
    )
    return ground.model_copy(update={"layers": layers})


def slowest_wave(ground: Ground) -> float:
    speeds = [surface_wave_speeds(ground, f) for f in (2.0, 10.0, 40.0)]
    return min((float(each[0]) for each in speeds if each.size), default=ground.slowest_speed)


def points(seed: int) -> list[tuple[float, float]]:
    rng = np.random.default_rng([13, seed])
    return [
        (float(np.exp(rng.uniform(np.log(2.0), np.log(40.0)))), float(share))
        for share in [0.0, *rng.uniform(0.1, 0.9, 4)]
    ]


@pytest.mark.parametrize("seed", range(SOILS))
def test_random_points(seed, track):
    """Standing, and at four speeds up to 0.9 of the slowest surface wave: 1e-4 of the receptance at the
    load.
    """
    ground = soil(seed)
    slowest = slowest_wave(ground)
    for frequency, share in points(seed):
        speed = share * slowest
        expected = receptance_by_quadrature(ground, track, frequency, DISTANCES, speed)
        sigma = rail_receptance(track, ground, frequency, DISTANCES, speed)
        assert np.abs(sigma - expected).max() < 1e-4 * abs(expected[0]), (frequency, speed)


@pytest.mark.parametrize(("frequency", "speed"), [(6.0, 115.0), (15.0, 130.0), (30.0, 100.0), (5.0, 160.0)])
def test_faster_than_the_surface_waves(frequency, speed, track):
    """A layer of 90 m/s on 200 m/s: waves are outrun, and ω − βv changes sign inside the spectrum's peaks."""
    upper = Layer(shear_speed=90.0, dilatational_speed=250.0, density=1700.0, loss_factor=0.08, thickness=3.0)
    lower = Layer(shear_speed=200.0, dilatational_speed=500.0, density=1900.0, loss_factor=0.06)
    ground = Ground(layers=[upper, lower])
    with pytest.warns(PlausibilityWarning):
        check_speed(ground, track, speed)
    expected = receptance_by_quadrature(ground, track, frequency, DISTANCES, speed)
    sigma = rail_receptance(track, ground, frequency, DISTANCES, speed)
    assert np.abs(sigma - expected).max() < 1e-4 * abs(expected[0])


@pytest.mark.parametrize("seed", range(SOILS))
def test_standing_load_is_reciprocal_and_passive(seed, track):
    ground = soil(seed)
    frequency = np.geomspace(1.0, 60.0, 9)
    sigma = rail_receptance(track, ground, frequency[:, None], DISTANCES)
    np.testing.assert_allclose(sigma[:, 1], sigma[:, 2], rtol=1e-13)
    np.testing.assert_allclose(sigma[:, 3], sigma[:, 4], rtol=1e-13)
    assert np.all(sigma[:, 0].imag < 0.0)
    # The matrix of standing receptances between several points takes power, whatever forces act.
    positions = np.array([0.0, 2.7, 19.0])
    d = positions[:, None] - positions
    matrix = rail_receptance(track, ground, 20.0, d)
    power = -(matrix - matrix.conj().T) / 2j
    assert np.linalg.eigvalsh(power).min() > -1e-4 * np.abs(matrix).max()


def test_slow_load_is_a_standing_load(track):
    ground = soil(0)
    still = rail_receptance(track, ground, 15.0, DISTANCES)
    errors = [
        np.abs(rail_receptance(track, ground, 15.0, DISTANCES, v) - still).max() / abs(still[0])
        for v in (4.0, 0.4)
    ]
    assert errors[1] < 0.11 * errors[0]  # of first order in speed
    assert errors[1] < 2e-3
