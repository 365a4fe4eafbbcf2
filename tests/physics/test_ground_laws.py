"""Laws of the ground's flexibility, over the whole range for which it is stated."""

import math

import numpy as np
import pytest

from railvib.parameters.ground import Ground, Layer
from railvib.soil._kernels.layers import surface_flexibility
from railvib.soil.flexibility import ground_flexibility
from tests.physics.judges import flexibility_by_global_matrix, random_ground

STACKS = range(40)


def extreme_ground(seed: int) -> tuple[Ground, float, np.ndarray]:
    """Return a ground of the whole stated range, a frequency, and wavenumbers up to ρh = 1e4 of the
    thickest layer.
    """
    rng = np.random.default_rng([7, seed])
    base = "rigid" if seed % 2 else "half-space"
    count = int(rng.integers(1 if base == "rigid" else 2, 6))

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    layers = []
    for number in range(count):
        shear = between(30.0, 2000.0)
        layers.append(
            Layer(
                shear_speed=shear,
                dilatational_speed=shear * between(1.2, 20.0),
                density=between(1000.0, 3000.0),
                loss_factor=between(0.002, 0.5),
                thickness=None if base == "half-space" and number == count - 1 else between(0.05, 200.0),
            )
        )
    thickest = max(layer.thickness for layer in layers if layer.thickness is not None)
    frequency = between(0.1, 500.0)
    return Ground(layers=layers, base=base), frequency, np.append(np.geomspace(1e-4, 1e4, 33) / thickest, 0.0)


def split(ground: Ground, number: int, share: float) -> Ground:
    """Return a ground with one layer cut into two of the same material."""
    layer = ground.layers[number]
    if layer.thickness is None:
        parts = [layer.model_copy(update={"thickness": 100.0 * share}), layer]
    else:
        parts = [
            layer.model_copy(update={"thickness": layer.thickness * part}) for part in (share, 1.0 - share)
        ]
    return ground.model_copy(
        update={"layers": (*ground.layers[:number], *parts, *ground.layers[number + 1 :])}
    )


@pytest.mark.parametrize("seed", STACKS)
def test_splitting_a_layer_changes_nothing(seed):
    ground, frequency, wavenumber = extreme_ground(seed)
    q = ground_flexibility(ground, wavenumber, frequency)
    assert np.all(np.isfinite(q))
    for number in range(len(ground.layers)):
        again = ground_flexibility(split(ground, number, 0.37), wavenumber, frequency)
        # Rounding only; the law asks for 1e-9.
        np.testing.assert_allclose(again, q, rtol=1e-11)


@pytest.mark.parametrize("seed", STACKS)
def test_against_long_arithmetic(seed):
    """An independent formulation, with digits enough to lose: potentials, all conditions in one system."""
    ground, frequency, wavenumber = extreme_ground(seed)
    thickest = max(layer.thickness for layer in ground.layers if layer.thickness is not None)
    for rho in wavenumber[[0, 12, 16, 18, 20, 24, -1]]:
        digits = 60 + int(0.5 * rho * thickest) + 20 * len(ground.layers)
        if digits > 250:
            continue
        expected = flexibility_by_global_matrix(ground, float(rho), frequency, digits)
        assert abs(ground_flexibility(ground, rho, frequency) / expected - 1.0) < 1e-11


def test_complex_wavenumber_against_long_arithmetic(greby):
    stack = greby.stack()
    for rho in (0.3 + 0.05j, 1.0 - 0.2j, 3.0 + 0.1j):
        expected = flexibility_by_global_matrix(greby, rho, 20.0)
        assert abs(surface_flexibility(rho, 40.0 * np.pi, stack, False) / expected - 1.0) < 1e-12


@pytest.mark.parametrize("frequency", [0.1, 5.0, 500.0])
def test_equal_layers_are_a_half_space(horstwalde, frequency):
    (layer,) = horstwalde.layers
    layers = [layer.model_copy(update={"thickness": h}) for h in (0.05, 3.0, 200.0, 0.7)]
    wavenumber = np.geomspace(1e-3, 50.0, 60)
    expected = ground_flexibility(horstwalde, wavenumber, frequency)
    q = ground_flexibility(Ground(layers=[*layers, layer]), wavenumber, frequency)
    np.testing.assert_allclose(q, expected, rtol=1e-11)


def test_half_space_depends_on_slowness_only(horstwalde):
    slowness = np.geomspace(1e-4, 1.0, 50)
    expected = ground_flexibility(horstwalde, slowness * 2.0 * np.pi, 1.0)
    for frequency in (0.1, 17.0, 500.0):
        q = ground_flexibility(horstwalde, slowness * 2.0 * np.pi * frequency, frequency)
        np.testing.assert_allclose(q * frequency, expected, rtol=1e-12)


@pytest.mark.parametrize("seed", STACKS[::4])
def test_flexibility_scales_with_size_and_stiffness(seed):
    """Lengths a-fold at frequencies a-fold lower, and b-fold densities: dimensional analysis leaves
    a/b-fold... of 1/(μρ).
    """
    ground, frequency, wavenumber = extreme_ground(seed)
    larger = ground.model_copy(
        update={
            "layers": tuple(
                each.model_copy(
                    update={
                        "density": 3.0 * each.density,
                        "thickness": None if each.thickness is None else 2.0 * each.thickness,
                    }
                )
                for each in ground.layers
            )
        }
    )
    q = ground_flexibility(ground, wavenumber, frequency)
    np.testing.assert_allclose(
        ground_flexibility(larger, 0.5 * wavenumber, 0.5 * frequency), q * 2.0 / 3.0, rtol=1e-10
    )


@pytest.mark.parametrize("seed", STACKS[::2])
def test_short_waves_feel_the_top_layer_at_rest(seed):
    """Q33 → (1 − ν)/(μρ), ν and μ of the top layer (law 6); the next term is of order (k_s/ρ)²."""
    ground, frequency, _ = extreme_ground(seed)
    top = ground.layers[0]
    rho = max(40.0 / (top.thickness or np.inf), 1e4 * 2.0 * math.pi * frequency / top.shear_speed)
    modulus = top.shear_modulus * (1.0 + 1j * top.loss_factor)
    assert (
        abs(ground_flexibility(ground, rho, frequency) * modulus * rho / (1.0 - top.poisson_ratio) - 1.0)
        < 1e-7
    )


def test_static_half_space():
    layer = Layer(shear_speed=200.0, dilatational_speed=400.0, density=2000.0, loss_factor=0.1)
    rho = np.geomspace(1e-3, 1e4, 20)
    expected = (1.0 - layer.poisson_ratio) / (layer.shear_modulus * rho)
    np.testing.assert_allclose(ground_flexibility(Ground(layers=[layer]), rho, 0.0), expected, rtol=1e-13)


def test_static_limit_is_reached_smoothly(greby):
    """From 1e-4 Hz the flexibility is that at rest, apart from the damping: Q33 of moduli times 1 + iη."""
    same = Ground(layers=[each.model_copy(update={"loss_factor": 0.1}) for each in greby.layers])
    rho = np.geomspace(0.01, 30.0, 20)
    q = ground_flexibility(same, rho, 1e-4)
    np.testing.assert_allclose(q * (1.0 + 0.1j), ground_flexibility(same, rho, 0.0), rtol=1e-5)


def test_long_waves_on_a_rigid_base_are_a_column():
    """At ρ = 0 the layer is a rod of P waves: tan(k_p h)/(k_p (λ + 2μ))."""
    layer = Layer(
        shear_speed=150.0, dilatational_speed=400.0, density=1900.0, loss_factor=0.05, thickness=7.0
    )
    ground = Ground(layers=[layer], base="rigid")
    for frequency in (0.5, 14.0, 90.0):
        omega = 2.0 * math.pi * frequency
        modulus = 1900.0 * 400.0**2 * (1.0 + 0.05j)
        k = omega / np.sqrt(modulus / 1900.0)
        assert (
            abs(ground_flexibility(ground, 0.0, frequency) / (np.tan(k * 7.0) / (k * modulus)) - 1.0) < 1e-12
        )


@pytest.mark.parametrize("seed", STACKS)
def test_passive_and_continuous(seed):
    ground, frequency, _ = extreme_ground(seed)
    low_loss = min(layer.loss_factor for layer in ground.layers)
    centre = 2.0 * math.pi * frequency / min(ground.wave_speeds())
    wavenumber = centre * np.linspace(0.0, 3.0, 400)
    q = ground_flexibility(ground, wavenumber, frequency)
    assert np.all(q.imag < 0.0)  # the ground takes power, never gives it
    steps = ground_flexibility(ground, wavenumber * (1.0 + 1e-9), frequency)
    # The sharpest peak has a relative width of about half the loss factor; layers of 200 m make many of them.
    assert np.abs(steps / q - 1.0).max() < 1e-9 * 1e3 / low_loss


def test_negative_frequency_is_the_conjugate(greby):
    rho = np.linspace(0.0, 3.0, 7)
    q = ground_flexibility(greby, rho, 20.0)
    np.testing.assert_array_equal(ground_flexibility(greby, rho, -20.0), q.conj())
    np.testing.assert_array_equal(ground_flexibility(greby, -rho, 20.0), q)


@pytest.mark.parametrize("seed", range(3))
def test_random_soils_against_long_arithmetic(seed):
    rng = np.random.default_rng([8, seed])
    for base in ("half-space", "rigid"):
        ground = random_ground(rng, base=base)
        for rho, frequency in ((0.1, 1.0), (0.7, 12.0), (2.0, 60.0)):
            expected = flexibility_by_global_matrix(ground, rho, frequency)
            assert abs(ground_flexibility(ground, rho, frequency) / expected - 1.0) < 1e-12
