"""Surface waves: Rayleigh's equation, modes under damping, and the waves of track and ground together."""

import numpy as np
import pytest
from scipy.optimize import brentq, newton

from railvib.errors import InputError
from railvib.parameters.ground import Ground, Layer
from railvib.soil._kernels.layers import surface_flexibility
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.surface_waves import slowest_surface_wave_speed, surface_wave_speeds
from railvib.transfer.critical_speed import critical_speed
from tests.physics.judges import random_ground, rayleigh_mode_count


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
        assert np.all(np.diff(speeds) >= 0.0)
        assert np.all(speeds > 0.85 * min(layer.shear_speed for layer in ground.layers))
        if len(ground.layers) == 1 and ground.base == "half-space":
            assert speeds.size == 1


@pytest.mark.parametrize("seed", range(20))
def test_the_slowest_alone_is_the_first_of_all(seed):
    rng = np.random.default_rng([22, seed])
    ground = random_ground(rng, base="rigid" if seed % 5 == 4 else "half-space")
    for frequency in 10.0 ** rng.uniform(0.0, 2.0, 3):
        speeds = surface_wave_speeds(ground, float(frequency))
        slowest = slowest_surface_wave_speed(ground, float(frequency))
        assert slowest == pytest.approx(speeds[0] if speeds.size else np.inf, rel=1e-9)


def with_damping(ground, loss_factor):
    layers = [layer.model_copy(update={"loss_factor": loss_factor}) for layer in ground.layers]
    return Ground(layers=layers, base=ground.base)


def of_layers(*layers):
    """A ground of (shear speed, thickness) with c_p = 4 c_s."""
    return Ground(
        layers=[
            Layer(
                shear_speed=shear,
                dilatational_speed=4.0 * shear,
                density=1800.0,
                loss_factor=0.05,
                thickness=thickness,
            )
            for shear, thickness in layers
        ]
    )


def assert_complete(ground, frequency, speeds):
    """Between every two modes, and at the base's shear speed, as many as an independent count has."""
    limit = ground.layers[-1].shear_speed * (1.0 - 1e-7)
    between = np.sqrt(speeds[1:] * speeds[:-1])[np.diff(speeds) > 1e-7 * speeds[1:]]
    trial = np.append(between, limit)
    count = rayleigh_mode_count(ground, 2.0 * np.pi * frequency / trial, frequency)
    np.testing.assert_array_equal(count, np.searchsorted(speeds, trial))


@pytest.mark.parametrize("loss_factor", [0.0, 1e-5, 1e-3])
@pytest.mark.parametrize("seed", range(25))
def test_all_modes_of_any_soil(seed, loss_factor):
    rng = np.random.default_rng([22, seed])
    ground = random_ground(rng, 7)
    frequency = float(10.0 ** rng.uniform(0.0, 2.3))
    speeds = surface_wave_speeds(with_damping(ground, loss_factor), frequency)
    assert_complete(ground, frequency, speeds)


@pytest.mark.parametrize("loss_factor", [0.0, 1e-5])
@pytest.mark.parametrize("frequency", [20.0, 100.0, 200.0])
@pytest.mark.parametrize(
    "ground",
    [
        of_layers((600.0, 10.0), (80.0, 3.0), (700.0, None)),
        of_layers((300.0, 3.0), (100.0, 3.0), (400.0, 30.0), (100.0, 3.0), (500.0, None)),
        of_layers((60.0, 1.0), (3000.0, None)),
        of_layers((250.0, 7.0), (86.0, 4.7), (134.0, 5.4), (304.0, 5.9), (95.0, None)),
        of_layers((100.0, 0.01), (110.0, 0.02), (200.0, None)),
    ],
    ids=["buried", "two equal channels", "contrast", "slow base", "thin"],
)
def test_all_modes_of_difficult_soil(ground, frequency, loss_factor):
    speeds = surface_wave_speeds(with_damping(ground, loss_factor), frequency)
    assert_complete(ground, frequency, speeds)


def test_modes_over_bedrock_appear_at_its_resonances():
    """Over rigid bedrock a mode appears where a shear or a dilatational wave resonates over the thickness."""
    ground = Ground(
        layers=[
            Layer(
                shear_speed=200.0,
                dilatational_speed=500.0,
                density=1800.0,
                loss_factor=0.0,
                thickness=10.0,
            )
        ],
        base="rigid",
    )
    resonances = np.array([200.0 / 40.0, 3.0 * 200.0 / 40.0, 500.0 / 40.0])  # 5, 15 and 12.5 Hz
    for frequency in (4.8, 5.2, 12.2, 12.8, 14.8, 15.2):
        expected = int((resonances < frequency).sum())
        # A mode whose energy goes backwards may begin below its resonance, and then comes with a forward one.
        assert (surface_wave_speeds(ground, frequency).size - expected) % 2 == 0
    assert surface_wave_speeds(ground, 4.8).size == 0
    assert surface_wave_speeds(ground, 5.2).size == 1


@pytest.mark.parametrize("seed", range(12))
def test_poles_of_the_flexibility_are_among_them(seed):
    """A strongly damped ground: every weakly damped pole of Q33's fit, polished on 1/Q33, is one."""
    rng = np.random.default_rng([23, seed])
    ground = random_ground(rng)
    frequency = float(10.0 ** rng.uniform(0.3, 2.0))
    omega = 2.0 * np.pi * frequency
    speeds = surface_wave_speeds(ground, frequency)

    def inverse(k):
        return 1.0 / complex(surface_flexibility(k, omega, ground.stack(), False))

    for start in np.sqrt(fit_flexibility(ground, frequency, 1e-9).pole):
        if not (abs(start.imag) < 0.2 * start.real and start.real > omega / ground.layers[-1].shear_speed):
            continue
        k, search = newton(inverse, start, x1=start * (1.0 + 1e-6), full_output=True, disp=False)
        if search.converged and abs(k - start) < 1e-3 * abs(start) and abs(k.imag) < 0.2 * k.real:
            assert np.abs(speeds / (omega / k.real) - 1.0).min(initial=1.0) < 1e-6


def test_damped_modes_are_near_the_elastic_ones(greby):
    elastic = Ground(layers=[each.model_copy(update={"loss_factor": 1e-4}) for each in greby.layers])
    damped = Ground(layers=[each.model_copy(update={"loss_factor": 0.05}) for each in greby.layers])
    for frequency in (5.0, 16.0, 40.0):
        assert surface_wave_speeds(damped, frequency)[0] == pytest.approx(
            surface_wave_speeds(elastic, frequency)[0], rel=0.01
        )


@pytest.mark.parametrize("frequency", [0.0, -5.0, np.nan, np.inf])
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
