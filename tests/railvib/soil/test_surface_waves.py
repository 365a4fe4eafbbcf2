"""Surface waves: Rayleigh's equation, modes under damping, and the waves of track and ground together."""

import numpy as np
import pytest
from scipy.optimize import brentq

from railvib.errors import InputError
from railvib.parameters.ground import Ground, Layer
from railvib.soil.surface_waves import surface_wave_speeds
from railvib.transfer.critical_speed import critical_speed
from tests.physics.judges import random_ground


def rayleigh_speed(cs, cp):
    def equation(c):
        return (2.0 - (c / cs) ** 2) ** 2 - 4.0 * np.sqrt((1.0 - (c / cp) ** 2) * (1.0 - (c / cs) ** 2))

    return brentq(equation, 0.6 * cs, 0.99999 * cs)


@pytest.mark.parametrize("ratio", [1.2, 1.5, 2.0, 6.0, 20.0])
@pytest.mark.parametrize("frequency", [0.5, 30.0])
def test_half_space(ratio, frequency):
    ground = Ground(
        layers=[Layer(shear_speed=200.0, dilatational_speed=200.0 * ratio, density=1800.0, loss_factor=1e-4)]
    )
    (speed,) = surface_wave_speeds(ground, frequency)
    assert speed == pytest.approx(rayleigh_speed(200.0, 200.0 * ratio), rel=1e-7)


@pytest.mark.parametrize("ratio", [1.16, 1.3, 1.42, 2.0, 20.0])
def test_lower_bound(ratio):
    """`Ground.slowest_speed` is a bound for auxetic soils (c_p/c_s < √2) too, whose Rayleigh wave is as
    slow as 0.69 c_s.
    """
    ground = Ground(
        layers=[Layer(shear_speed=200.0, dilatational_speed=200.0 * ratio, density=1800.0, loss_factor=0.01)]
    )
    assert ground.slowest_speed <= rayleigh_speed(200.0, 200.0 * ratio)


@pytest.mark.parametrize("seed", range(40))
def test_any_soil(seed):
    """Whatever the soil and the frequency, an answer: ascending speeds between the bounds."""
    rng = np.random.default_rng([21, seed])
    ground = random_ground(rng, base="rigid" if seed % 5 == 4 else "half-space")
    for frequency in 10.0 ** rng.uniform(0.0, 2.0, 6):
        speeds = surface_wave_speeds(ground, float(frequency))
        assert np.all(np.diff(speeds) > 0.0)
        assert np.all(speeds > 0.85 * min(layer.shear_speed for layer in ground.layers))
        if len(ground.layers) == 1 and ground.base == "half-space":
            assert speeds.size == 1


def test_damped_modes_are_near_the_elastic_ones(greby):
    elastic = Ground(layers=[each.model_copy(update={"loss_factor": 1e-4}) for each in greby.layers])
    damped = Ground(layers=[each.model_copy(update={"loss_factor": 0.05}) for each in greby.layers])
    for frequency in (5.0, 16.0, 40.0):
        assert surface_wave_speeds(damped, frequency)[0] == pytest.approx(
            surface_wave_speeds(elastic, frequency)[0], rel=0.01
        )


@pytest.mark.parametrize("frequency", [0.0, -5.0, np.nan])
def test_refused(frequency, greby):
    with pytest.raises(InputError, match="frequency"):
        surface_wave_speeds(greby, frequency)


def test_critical_speed(horstwalde, greby, track):
    """Of a light track on a stiff half-space nearly the Rayleigh speed; soft layers on a stiff one are
    slower still.
    """
    light = track.model_copy(
        update={
            "rail_mass": 1.0,
            "sleeper_mass": 1.0,
            "layers": (track.layers[0].model_copy(update={"mass": 0.0}),),
        }
    )
    soil = Ground(layers=[horstwalde.layers[0].model_copy(update={"loss_factor": 0.01})])
    assert critical_speed(soil, light) == pytest.approx(rayleigh_speed(250.0, 1470.0), rel=0.06)
    assert critical_speed(greby, track) < critical_speed(horstwalde, track)
    heavy = track.model_copy(update={"sleeper_mass": 3000.0})
    assert critical_speed(soil, heavy) <= critical_speed(soil, light)
