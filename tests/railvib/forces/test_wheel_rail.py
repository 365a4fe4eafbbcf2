"""Wheel-rail forces against a vehicle and its contact solved as one system, on a rail of which only the
receptance counts.
"""

import numpy as np
import pytest

from railvib import library
from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import axle_forces, axle_numbers, axle_phases, force_matrices
from railvib.parameters.vehicle import Train, train_receptance


class Spring:
    """A rail that yields under the axle alone, 1/K, or along a decaying curve."""

    def __init__(self, train, stiffness, length=1e-3):
        self.distance = train.axle_distances
        self.value = np.exp(-np.abs(self.distance) / length) / stiffness

    def at(self, frequency):
        return np.tile(self.value.astype(complex), (frequency.size, 1))


@pytest.fixture(scope="module")
def mixed(vehicle):
    other = vehicle.model_copy(
        update={"wheelset_mass": 1500.0, "contact_stiffness_per_wheel": 1.2e9, "length": 24.0}
    )
    return Train(vehicles=[vehicle, other])


def test_distances_are_distinct_and_signed(train):
    d = train.axle_distances
    np.testing.assert_allclose(d, -d[::-1])
    assert np.all(np.diff(d) > 1e-6)
    assert d.size == 1 + 2 * 31  # 32 distances including 0, as METHOD says of the four-car train


def test_all_masses_in_one_system(vehicle):
    """Bounce, pitch and wheelsets of one vehicle, contact springs and rail springs: 10 + 4 equations at
    once.
    """
    train = Train(vehicles=[vehicle])
    rail = Spring(train, 8e7, 4.0)
    f = np.array([0.7, 1.4, 6.0, 30.0, 90.0])
    matrices = force_matrices(train, rail, f)
    alpha = train.axle_positions
    yields = np.exp(-np.abs(alpha[:, None] - alpha) / 4.0) / 8e7
    for row, frequency in enumerate(f):
        omega = 2.0 * np.pi * frequency
        k1 = vehicle.primary_stiffness + 1j * omega * vehicle.primary_damping
        k2 = vehicle.secondary_stiffness + 1j * omega * vehicle.secondary_damping
        k = np.zeros((10, 10), complex)  # car z, θ; bogies z, θ (rear, front); wheelsets ascending

        def couple(shape, stiffness, k=k):
            shape = np.array(shape)
            k += stiffness * np.outer(shape, shape)

        half, quarter = vehicle.bogie_spacing / 2.0, vehicle.axle_spacing / 2.0
        unit = np.eye(10)
        for bogie, side in ((0, -1.0), (1, 1.0)):
            z, turn = unit[2 + 2 * bogie], unit[3 + 2 * bogie]
            couple(unit[0] + side * half * unit[1] - z, k2)
            for axle, end in ((0, -1.0), (1, 1.0)):
                couple(z + end * quarter * turn - unit[6 + 2 * bogie + axle], k1)
        bogie_masses = [vehicle.bogie_mass, vehicle.bogie_pitch_inertia] * 2
        mass = np.diag(
            [vehicle.car_mass, vehicle.car_pitch_inertia, *bogie_masses, *[vehicle.wheelset_mass] * 4]
        )
        # Wheelset l: (K − ω²M) w = −P_l; rail u = Σ yields P; contact: w_l − u_l − w̃_l... P_l = −k_H (w̃ + u
        # − w).
        dynamic = k - omega**2 * mass
        system = np.zeros((14, 14), complex)
        system[:10, :10] = dynamic
        system[6:10, 10:] = np.eye(4)
        system[10:, 6:10] = -np.eye(4)
        system[10:, 10:] = yields + np.eye(4) / vehicle.contact_stiffness
        right = np.zeros((14, 4))
        right[10:] = -np.eye(4)
        expected = np.linalg.solve(system, right)[10:]
        np.testing.assert_allclose(matrices[row], expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


@pytest.fixture
def random_rail(mixed):
    rng = np.random.default_rng(4)
    rail = Spring(mixed, 4e7, 9.0)
    rail.value = rail.value * np.exp(1j * rng.uniform(-2.0, 2.0, rail.value.size))
    return rail


def compliances(train, rail, frequency):
    alpha = train.axle_positions
    column = [[np.argmin(np.abs(rail.distance - (one - other))) for other in alpha] for one in alpha]
    vehicles = train_receptance(train, 2.0 * np.pi * frequency)
    return rail.at(frequency)[:, np.array(column)] + vehicles + np.diag(1.0 / train.contact_stiffness)


@pytest.mark.parametrize("count", [1, 31, 70])
def test_elimination_against_lapack(mixed, random_rail, count):
    f = np.geomspace(0.005, 300.0, count)
    rng = np.random.default_rng(5)
    unevenness = rng.normal(size=(count, 8, 2)) @ [1.0, 1j]
    matrices = compliances(mixed, random_rail, f)
    forces = axle_forces(mixed, random_rail, f, unevenness)
    np.testing.assert_allclose(
        forces,
        -np.linalg.solve(matrices, unevenness[..., None])[..., 0],
        rtol=1e-9,
        atol=1e-12 * np.abs(forces).max(),
    )
    inverse = force_matrices(mixed, random_rail, f)
    np.testing.assert_allclose(
        inverse @ matrices, np.broadcast_to(-np.eye(8), matrices.shape), rtol=0, atol=1e-11
    )


def test_frequencies_do_not_depend_on_their_neighbours(mixed, random_rail):
    f = np.geomspace(0.5, 300.0, 70)
    phase = axle_phases(mixed, f, 40.0)
    together = axle_forces(mixed, random_rail, f, phase)
    alone = [axle_forces(mixed, random_rail, f[i : i + 1], phase[i : i + 1])[0] for i in (0, 31, 32, 69)]
    np.testing.assert_array_equal(together[[0, 31, 32, 69]], alone)


def test_a_matrix_that_needs_its_rows_exchanged(mixed, random_rail):
    """The first pivot is nothing: elimination in order would divide by it."""
    f = np.array([3.0, 20.0])
    first = compliances(mixed, random_rail, f[1:])[0, 0, 0]
    random_rail.value[random_rail.distance == 0.0] -= first * (1.0 - 1e-13)
    matrices = compliances(mixed, random_rail, f)
    assert abs(matrices[1, 0, 0]) < 1e-9 * np.abs(matrices[1]).max()
    forces = force_matrices(mixed, random_rail, f)
    np.testing.assert_allclose(
        forces @ matrices, np.broadcast_to(-np.eye(8), matrices.shape), rtol=0, atol=1e-9
    )


def test_stiff_wheels_and_heavy_masses_press_the_unevenness_into_the_rail(mixed):
    """At high frequency each wheelset stands still, and P = −w̃/(1/K + 1/k_H)."""
    rail = Spring(mixed, 2e7)
    matrices = force_matrices(mixed, rail, np.array([2000.0]))[0]
    expected = -1.0 / (1.0 / 2e7 + 1.0 / mixed.contact_stiffness)
    np.testing.assert_allclose(np.diag(matrices), expected, rtol=2e-3)
    np.testing.assert_allclose(matrices - np.diag(np.diag(matrices)), 0.0, atol=1e-2 * np.abs(expected).max())


def test_reciprocal_on_a_symmetric_rail(train):
    matrices = force_matrices(train, Spring(train, 5e7, 6.0), np.array([4.0, 40.0]))
    np.testing.assert_allclose(
        matrices, matrices.swapaxes(1, 2), rtol=1e-9, atol=1e-9 * np.abs(matrices).max()
    )


def test_arrivals_and_numbers(train):
    f = np.array([1.0, 10.0])
    phase = axle_phases(train, f, 40.0)
    np.testing.assert_allclose(phase, np.exp(1j * 2.0 * np.pi * f[:, None] / 40.0 * train.axle_positions))
    assert axle_numbers(train)[-1] == 1  # the largest x leads


def test_receptances_of_other_distances_are_not_mixed_up(train):
    """The matrix takes σ(α_j − α_k): an antisymmetric receptance shows which way round."""
    d = train.axle_distances
    rail = Receptances(
        frequency=np.geomspace(0.5, 3.0, 34),
        distance=d,
        receptance=np.tile(1e-9 * (np.abs(d) < 1e-9) + 1e-12 * d, (34, 1)).astype(complex),
        block=np.array([0]),
        level=np.array([0]),
        speed=0.0,
        interpolation_error=np.array([0.0]),
    )
    f = np.array([2.0])
    alpha = train.axle_positions
    compliance = 1e-9 * np.eye(16) + 1e-12 * (alpha[:, None] - alpha)
    compliance = (
        compliance + train_receptance(train, 2.0 * np.pi * f)[0] + np.diag(1.0 / train.contact_stiffness)
    )
    np.testing.assert_allclose(force_matrices(train, rail, f)[0], -np.linalg.inv(compliance), rtol=1e-8)


def test_any_vehicles_against_lapack():
    """A locomotive of ten degrees of freedom, wagons by parts, and cars on shared bogies, in one train."""
    names = ["chinese-star", "freight-y25-empty", "two-axle-wagon", "freight-y25-empty"]
    names += ["tram-front", "tram-middle", "tram-rear"]
    train = Train(vehicles=[library.load("vehicle", name) for name in names])
    rail = Spring(train, 4e7, 9.0)
    f = np.geomspace(0.05, 300.0, 41)
    matrices = force_matrices(train, rail, f)
    assert matrices.shape == (41, 22, 22)
    expected = -np.linalg.inv(compliances(train, rail, f))
    size = np.abs(expected).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(matrices / size, expected / size, rtol=0, atol=1e-11)
