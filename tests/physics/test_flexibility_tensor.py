"""Laws of the flexibility of the ground's surface in all three directions."""

import numpy as np
import pytest

from railvib.errors import InputError
from railvib.parameters.ground import Ground, Layer
from railvib.soil._kernels.layers import psv_flexibility, sh_flexibility, surface_components
from railvib.soil.flexibility import ground_flexibility
from railvib.soil.flexibility_tensor import ground_flexibility_tensor
from tests.consistency.reference import damped, rows
from tests.physics.judges import psv_by_global_matrix, random_ground

HALF_SPACE = Ground(
    layers=[Layer(shear_speed=150.0, dilatational_speed=280.0, density=1800.0, loss_factor=0.05)]
)


def along_x(ground, wavenumber, frequency):
    """Return what the recursion gives for a wave along x: u_x, u_z per p_x, p_z, and u_y per p_y."""
    tensor = ground_flexibility_tensor(ground, wavenumber, 0.0, frequency)
    return tensor[np.ix_([0, 2], [0, 2])], tensor[1, 1]


def love_by_propagator(ground, wavenumber, frequency):
    """Return u_y per p_y from Haskell's propagator matrices, layer by layer from the surface."""
    omega = 2.0 * np.pi * frequency
    total = np.eye(2, dtype=complex)
    for layer in ground.layers:
        loss = 1.0 + 1j * layer.loss_factor
        s = np.sqrt(wavenumber**2 - omega**2 / (layer.shear_speed**2 * loss) + 0j)
        m = layer.shear_modulus * loss
        if layer.thickness is None:
            below = np.array([1.0, -m * s])  # a wave that decays downward: u, τ
        else:
            c, d = np.cosh(s * layer.thickness), np.sinh(s * layer.thickness)
            total = np.array([[c, d / (m * s)], [m * s * d, c]]) @ total
    # u and τ at the surface for the half-space's wave, or for no displacement on a rigid base.
    if ground.base == "rigid":
        return total[0, 1] / total[0, 0]
    u, stress = np.linalg.solve(total, below)
    return -u / stress


def test_vertical_component_is_that_of_the_scalar_function(greby):
    beta, gamma = np.array([0.0, 0.3, 2.0]), np.array([[0.1], [0.8], [40.0]])
    for frequency in (0.0, 5.0, -20.0, 100.0):
        tensor = ground_flexibility_tensor(greby, beta, gamma, frequency)
        scalar = ground_flexibility(greby, np.hypot(beta, gamma), frequency)
        np.testing.assert_allclose(tensor[..., 2, 2], scalar, rtol=1e-10)


@pytest.mark.parametrize("base", ["half-space", "rigid"])
def test_p_sv_equals_global_matrix(base):
    rng = np.random.default_rng(4)
    for _ in range(4):
        ground = random_ground(rng, 3, base)
        frequency = float(np.exp(rng.uniform(np.log(0.5), np.log(200.0))))
        for slowness in (0.1, 0.9, 1.3, 40.0):
            k = 2.0 * np.pi * frequency * slowness / ground.slowest_speed
            judged = psv_by_global_matrix(ground, k, frequency)
            found, _sh = along_x(ground, k, frequency)
            np.testing.assert_allclose(found, judged, rtol=0.0, atol=1e-11 * abs(judged).max())


@pytest.mark.parametrize("base", ["half-space", "rigid"])
def test_sh_equals_propagator_matrices(base):
    rng = np.random.default_rng(5)
    for _ in range(6):
        ground = random_ground(rng, 3, base)
        for slowness in (0.1, 0.9, 1.3):
            k = 2.0 * np.pi * 8.0 * slowness / ground.slowest_speed
            _psv, found = along_x(ground, k, 8.0)
            assert abs(found / love_by_propagator(ground, k, 8.0) - 1.0) < 1e-9


def test_sh_of_half_space_in_closed_form():
    (layer,) = HALF_SPACE.layers
    loss = 1.0 + 0.05j
    k = np.array([1e-6, 0.1, 1.0, 30.0])
    shear = 2.0 * np.pi * 20.0 / layer.shear_speed / np.sqrt(loss)
    closed = 1.0 / (layer.shear_modulus * loss * np.sqrt(k**2 - shear**2))
    tensor = ground_flexibility_tensor(HALF_SPACE, k, 0.0, 20.0)
    np.testing.assert_allclose(tensor[:, 1, 1], closed, rtol=1e-12)


@pytest.mark.parametrize(
    "row", [each for each in rows("rayleigh_love_greby") if each["mode"].startswith("L")]
)
def test_love_waves_are_poles(greby, row):
    """1/q_tt of the undamped ground is real where waves are trapped, and changes sign at each mode."""
    stack = damped(greby, 0.0).stack()
    omega = 2.0 * np.pi * float(row["frequency_hz"])
    stiffness = [
        1.0 / sh_flexibility(omega / (float(row["phase_speed_m_s"]) * factor), omega, stack, False)
        for factor in (1.0 - 1e-5, 1.0 + 1e-5)
    ]
    assert stiffness[0].real > 0.0 > stiffness[1].real


def test_reciprocity(greby):
    beta, gamma = np.array([0.0, 0.3, -2.0, 1e-4, 60.0]), np.array([0.7, -0.2, 1.0, 1e-4, 80.0])
    tensor = ground_flexibility_tensor(greby, beta, gamma, 20.0)
    opposite = ground_flexibility_tensor(greby, -beta, -gamma, 20.0)
    np.testing.assert_allclose(tensor, opposite.swapaxes(1, 2), rtol=1e-14)
    # The recursion knows nothing of it: both off-diagonal terms come out equal.
    for r in np.hypot(beta, gamma):
        _q11, q12, q21, q22 = psv_flexibility(r, 126.0, greby.stack(), False)
        assert abs(q12 - q21) < 1e-13 * abs(q22)


def test_axes_do_not_matter(greby):
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    there = ground_flexibility_tensor(greby, 0.5, 0.2, 12.0)
    turned = ground_flexibility_tensor(greby, *(turn[:2, :2] @ [0.5, 0.2]), 12.0)
    np.testing.assert_allclose(turned, turn @ there @ turn.T, rtol=0.0, atol=1e-13 * abs(there).max())


def test_passivity(greby):
    """What goes in is not given back: the Hermitian part of i Q is negative definite for ω > 0."""
    beta = np.linspace(0.0, 3.0, 30)
    tensor = ground_flexibility_tensor(greby, beta, beta[:, None] * 0.7, 25.0)
    power = (tensor - tensor.conj().swapaxes(-1, -2)) / 2j
    assert np.linalg.eigvalsh(power[1:, 1:]).max() < 0.0


@pytest.mark.parametrize("frequency", [0.0, 3.0])
def test_static_limits(frequency):
    """Boussinesq's and Cerruti's half-space at ω = 0, and far above k_s: digits are not lost on the way."""
    (layer,) = HALF_SPACE.layers
    nu, m = layer.poisson_ratio, layer.shear_modulus * (1.0 + (0.05j if frequency else 0.0))
    for r in (2.0, 100.0, 3000.0) if frequency == 0.0 else (3000.0,):
        q_zz, q_rr, q_tt, q_rz = (
            m
            * r
            * surface_components(np.array([r]), 2.0 * np.pi * frequency, HALF_SPACE.stack(), False)[:, 0]
        )
        # At 3 Hz the waves are still felt like (k_s/r)².
        np.testing.assert_allclose(
            [q_zz, q_rr, q_tt, q_rz],
            [1.0 - nu, 1.0 - nu, 1.0, 0.5 * (1.0 - 2.0 * nu)],
            rtol=1e-13 if frequency == 0.0 else 1e-8,
        )


def test_layers_go_to_their_static_limits(greby):
    """A stratified ground's response is continuous down to ω = 0, and at depth-blind wavenumbers is that of
    its top layer.
    """
    undamped = damped(greby, 0.0)
    r = np.array([1e-2, 0.3, 4.0, 50.0])
    still = surface_components(r, 0.0, undamped.stack(), False)
    slow = surface_components(r, 2.0 * np.pi * 1e-3, undamped.stack(), False)
    np.testing.assert_allclose(slow, still, rtol=2e-5)
    top = Ground(layers=[undamped.layers[0].model_copy(update={"thickness": None})])
    np.testing.assert_allclose(surface_components(r[3:], 0.0, top.stack(), False), still[:, 3:], rtol=1e-12)


def test_vertical_load_draws_the_surface_inward():
    """Boussinesq: u_x = −(1 − 2ν) F x/(4πμ r²), so Q_xz = iβ(1 − 2ν)/(2μρ²)."""
    (layer,) = HALF_SPACE.layers
    tensor = ground_flexibility_tensor(HALF_SPACE, 3.0, 4.0, 0.0)
    c = (1.0 - 2.0 * layer.poisson_ratio) / (2.0 * layer.shear_modulus * 25.0)
    np.testing.assert_allclose(tensor[:2, 2], [3j * c, 4j * c], rtol=1e-12)


def test_splitting_a_layer_changes_nothing(greby):
    half = greby.layers[0].model_copy(update={"thickness": 1.0})
    split = Ground(layers=[half, half, *greby.layers[1:]])
    wavenumber = np.array([0.05, 0.6, 1.4, 20.0])
    there = ground_flexibility_tensor(greby, wavenumber, 0.3, 30.0)
    np.testing.assert_allclose(
        ground_flexibility_tensor(split, wavenumber, 0.3, 30.0), there, rtol=0, atol=1e-12 * abs(there).max()
    )


def test_negative_frequency_makes_real_signals(greby):
    there = ground_flexibility_tensor(greby, 0.4, 0.3, 15.0)
    np.testing.assert_array_equal(
        ground_flexibility_tensor(greby, 0.4, 0.3, -15.0),
        ground_flexibility_tensor(greby, -0.4, -0.3, 15.0).conj(),
    )
    assert there.shape == (3, 3)


def test_compiled_equals_plain(greby):
    stack = Ground(layers=[greby.layers[0], greby.layers[1]], base="rigid").stack()
    for omega in (0.0, 50.0):
        for r in (1e-4, 0.5, 700.0):
            compiled = sh_flexibility(r, omega, stack, True)
            assert abs(sh_flexibility.py_func(r, omega, stack, True) / compiled - 1.0) < 1e-12


def test_half_space_yields_without_bound_at_rest():
    with pytest.raises(InputError, match="without bound"):
        ground_flexibility_tensor(HALF_SPACE, 0.0, 0.0, 0.0)
