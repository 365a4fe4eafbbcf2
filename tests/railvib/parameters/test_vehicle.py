"""The vehicle: laws of a free passive structure, and an independent ten-degree-of-freedom matrix model."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from railvib.errors import InputError, PlausibilityWarning
from railvib.parameters.vehicle import (
    Train,
    Vehicle,
    train_receptance,
    wheelset_receptance,
)

# Section 4 of the paper.
REGINA = {
    "car_mass": 40e3,
    "car_pitch_inertia": 2e6,
    "bogie_mass": 5e3,
    "bogie_pitch_inertia": 6e3,
    "wheelset_mass": 1.8e3,
    "primary_stiffness": 2.4e6,
    "primary_damping": 30e3,
    "secondary_stiffness": 0.6e6,
    "secondary_damping": 20e3,
    "axle_spacing": 2.7,
    "bogie_spacing": 19.0,
    "length": 26.6,
    "axle_load": 140.1e3,
    "contact_stiffness_per_wheel": 1462.5e6,
}


def regina(**changes):
    return Vehicle(**{**REGINA, **changes})


def locomotive():
    return regina(
        car_mass=60e3,
        bogie_mass=9e3,
        wheelset_mass=2.5e3,
        axle_spacing=3.0,
        bogie_spacing=10.0,
        length=19.0,
        axle_load=216e3,
        contact_stiffness_per_wheel=1.2e9,
    )


def matrices(vehicle):
    """Assemble M, K and C spring by spring: car z and pitch, each bogie's z and pitch, four wheelsets."""
    half_bogies, half_axles = vehicle.bogie_spacing / 2, vehicle.axle_spacing / 2
    bogie = [vehicle.bogie_mass, vehicle.bogie_pitch_inertia]
    mass = np.diag(
        [vehicle.car_mass, vehicle.car_pitch_inertia, *bogie, *bogie] + 4 * [vehicle.wheelset_mass]
    )
    stiffness, damping = np.zeros((10, 10)), np.zeros((10, 10))

    def connect(elongation, k, c):
        stiffness[:] += k * np.outer(elongation, elongation)
        damping[:] += c * np.outer(elongation, elongation)

    for number, along in enumerate((-half_bogies, half_bogies)):
        elongation = np.zeros(10)
        elongation[[0, 1, 2 + 2 * number]] = 1.0, along, -1.0
        connect(elongation, vehicle.secondary_stiffness, vehicle.secondary_damping)
        for axle, position in enumerate((-half_axles, half_axles)):
            elongation = np.zeros(10)
            elongation[[2 + 2 * number, 3 + 2 * number, 6 + 2 * number + axle]] = 1.0, position, -1.0
            connect(elongation, vehicle.primary_stiffness, vehicle.primary_damping)
    return mass, stiffness, damping


@pytest.mark.parametrize("frequency", [0.01, 0.1, 1.0, 3.0, 10.0, 100.0, 500.0])
@pytest.mark.parametrize("vehicle", [regina(), locomotive()], ids=["regina", "locomotive"])
def test_matrix_model(vehicle, frequency):
    mass, stiffness, damping = matrices(vehicle)
    omega = 2 * np.pi * frequency
    dynamic = stiffness + 1j * omega * damping - omega**2 * mass
    selection = np.eye(10)[:, 6:]
    expected = selection.T @ np.linalg.solve(dynamic, selection)
    np.testing.assert_allclose(
        wheelset_receptance(vehicle, omega), expected, rtol=0, atol=1e-9 * abs(expected).max()
    )


def test_natural_frequencies():
    vehicle = regina(primary_damping=0.0, secondary_damping=0.0)
    mass, stiffness, _ = matrices(vehicle)
    squares = scipy.linalg.eigh(stiffness, mass, eigvals_only=True)
    # Bounce and pitch of the whole free vehicle, and each bogie with its wheelsets about its own centre.
    assert np.all(np.abs(squares[:4]) < 1e-9 * squares[4])
    for each in np.sqrt(squares[4:]):
        below = np.linalg.eigvalsh(wheelset_receptance(vehicle, each * (1 - 1e-7)).real)
        above = np.linalg.eigvalsh(wheelset_receptance(vehicle, each * (1 + 1e-7)).real)
        assert below.max() > 100 * abs(wheelset_receptance(vehicle, each * 1.01)).max()
        assert above.min() < -100 * abs(wheelset_receptance(vehicle, each * 1.01)).max()


@pytest.mark.parametrize("changes", [{}, {"secondary_damping": 0.0}, {"primary_damping": 400e3}])
def test_modes_on_held_wheelsets(changes):
    """Those of the matrix model without its wheelsets, as far as they oscillate."""
    vehicle = regina(**changes)
    mass, stiffness, damping = (matrix[:6, :6] for matrix in matrices(vehicle))
    state = np.block(
        [
            [np.zeros((6, 6)), np.eye(6)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
        ]
    )
    eigenvalue = np.linalg.eigvals(state)
    oscillating = eigenvalue[eigenvalue.imag > 1e-6]
    modes = vehicle.suspension_modes
    for mode in modes:
        assert np.abs(oscillating - mode).min() < 1e-6 * np.abs(mode)
    for mode in oscillating:  # the two bogies pitch alike
        assert np.abs(modes - mode).min() < 1e-6 * np.abs(mode)


@settings(deadline=None, max_examples=60)
@given(
    frequency=st.floats(0.01, 500.0),
    primary=st.floats(1e5, 1e8),
    damping=st.floats(0.0, 1e5),
    inertia=st.floats(1e3, 1e7),
)
def test_symmetry_and_passivity(frequency, primary, damping, inertia):
    vehicle = regina(primary_stiffness=primary, primary_damping=damping, car_pitch_inertia=inertia)
    receptance = wheelset_receptance(vehicle, 2 * np.pi * frequency)
    np.testing.assert_array_equal(receptance, receptance.T)
    absorbed = np.linalg.eigvalsh(receptance.imag)
    assert absorbed.max() <= 1e-14 * abs(receptance).max()
    np.testing.assert_array_equal(wheelset_receptance(vehicle, -2 * np.pi * frequency), receptance.conj())


def test_rigid_body_limit_bounce():
    vehicle = regina()
    omega = 2 * np.pi * 0.01
    displacement = wheelset_receptance(vehicle, omega) @ np.ones(4)  # a unit force on each wheelset
    np.testing.assert_allclose(displacement, -4 / (vehicle.total_mass * omega**2), rtol=1e-3)


def test_rigid_body_limit_pitch():
    vehicle = regina()
    omega = 2 * np.pi * 0.01
    arm = np.array([-9.5, -9.5, 9.5, 9.5])
    # Forces in antiphase on the two bogies turn the car; nothing turns the bogies, which go up and down.
    masses = vehicle.bogie_mass / 2 + vehicle.wheelset_mass
    inertia = vehicle.car_pitch_inertia + 4 * masses * 9.5**2
    rotation = -4 * 9.5 / (inertia * omega**2)
    np.testing.assert_allclose(wheelset_receptance(vehicle, omega) @ np.sign(arm), rotation * arm, rtol=1e-3)


def test_rigid_limit_is_approached_without_loss_of_digits():
    vehicle = regina()
    deviation = []
    for frequency in (1e-3, 1e-4, 1e-5):
        omega = 2 * np.pi * frequency
        displacement = wheelset_receptance(vehicle, omega) @ np.ones(4)
        deviation.append(abs(displacement[0] * vehicle.total_mass * omega**2 / -4 - 1))
    np.testing.assert_allclose(deviation[0] / np.array(deviation[1:]), [1e2, 1e4], rtol=0.05)


def test_high_frequency_limit_is_the_wheelset_alone():
    vehicle = regina()
    omega = 2 * np.pi * 500.0
    receptance = wheelset_receptance(vehicle, omega)
    free = -1 / (vehicle.wheelset_mass * omega**2)
    np.testing.assert_allclose(np.diag(receptance), free, rtol=0.01)
    assert abs(receptance - np.diag(np.diag(receptance))).max() < 1e-3 * abs(free)


def test_axle_positions_of_the_paper():
    train = Train(vehicles=(regina(),) * 4)
    expected = sorted(
        13.3 + 26.6 * j + bogie + axle for j in range(4) for bogie in (-9.5, 9.5) for axle in (-1.35, 1.35)
    )
    np.testing.assert_allclose(train.axle_positions, expected, rtol=1e-14)
    assert train.axle_count == 16
    assert train.length == pytest.approx(106.4)
    assert np.ptp(train.axle_positions) == pytest.approx(101.5)
    np.testing.assert_array_equal(train.axle_loads, np.full(16, 140.1e3))
    np.testing.assert_array_equal(train.contact_stiffness, np.full(16, 2925e6))


def test_first_vehicle_leads():
    train = Train(vehicles=(locomotive(), regina(), regina()))
    positions = train.axle_positions
    assert np.all(np.diff(positions) > 0)
    assert train.length == pytest.approx(19.0 + 2 * 26.6)
    leading = 2 * 26.6 + 9.5 + np.array([-6.5, -3.5, 3.5, 6.5])
    np.testing.assert_allclose(positions[-4:], leading)
    np.testing.assert_array_equal(train.axle_loads, [140.1e3] * 8 + [216e3] * 4)
    np.testing.assert_array_equal(train.contact_stiffness, [2.925e9] * 8 + [2.4e9] * 4)


def test_train_receptance_is_block_diagonal():
    train = Train(vehicles=(locomotive(), regina()))
    omega = 2 * np.pi * np.array([1.0, 20.0])
    receptance = train_receptance(train, omega)
    assert receptance.shape == (2, 8, 8)
    np.testing.assert_array_equal(receptance[:, :4, :4], wheelset_receptance(regina(), omega))
    np.testing.assert_array_equal(receptance[:, 4:, 4:], wheelset_receptance(locomotive(), omega))
    assert not receptance[:, :4, 4:].any()
    assert not receptance[:, 4:, :4].any()


def test_study_form_is_the_same_object():
    vehicle = regina()
    study_form = vehicle.model_dump(by_alias=True)
    assert study_form["car_mass_kg"] == 40e3
    assert Vehicle(**study_form) == vehicle
    train = Train(vehicles=(vehicle, locomotive()))
    assert Train(**train.model_dump(by_alias=True)) == train


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"car_mass": -1.0}, r"Vehicle\.car_mass.* = -1\.0 kg: should be greater than or equal to 100 kg"),
        ({"secondary_damping": float("nan")}, r"secondary_damping.* = nan"),
        ({"axle_spacing": 19.0}, r"axle_spacing_m = 19 m: must be below bogie_spacing_m = 19 m"),
        ({"length": 20.0}, r"length_m = 20 m: must be at least bogie_spacing_m \+ axle_spacing_m = 21\.7 m"),
        ({"colour": "red"}, r"Vehicle\.colour: unknown key"),
    ],
)
def test_refusals(changes, message):
    with pytest.raises(InputError, match=message):
        regina(**changes)


def test_a_train_has_vehicles():
    with pytest.raises(InputError, match="vehicles"):
        Train(vehicles=())


def test_axle_load_that_does_not_fit_the_masses_warns():
    with pytest.warns(PlausibilityWarning, match="57200 kg"):
        regina(axle_load=14.01e3)


@pytest.mark.parametrize("omega", [0.0, float("nan"), float("inf")])
def test_no_static_receptance(omega):
    with pytest.raises(InputError, match="angular_frequency"):
        wheelset_receptance(regina(), [1.0, omega])
