"""Vehicles by parts: laws of free passive structures, and models assembled by hand, spring by spring."""

import numpy as np
import pytest
import scipy.linalg

from railvib.errors import InputError
from railvib.parameters.composite_vehicle import CompositeVehicle
from railvib.parameters.rake import Rake
from railvib.parameters.units import GRAVITY
from railvib.parameters.vehicle import Vehicle, wheelset_receptance
from tests.railvib.parameters.test_vehicle import locomotive, regina

CONTACT = {"contact_stiffness_per_wheel_n_m": 1.4e9}


def axle(position, load=None, mass=1400.0, stiffness=5.2e6, damping=30e3):
    given = {} if load is None else {"axle_load_n": load}
    return {
        "position_m": position,
        "wheelset_mass_kg": mass,
        "primary_stiffness_n_m": stiffness,
        "primary_damping_n_s_m": damping,
        **given,
    }


def bogie(position, **keys):
    return {
        "position_m": position,
        "mass_kg": 1800.0,
        "pitch_inertia_kg_m2": 1700.0,
        "axles": [axle(position - 0.9), axle(position + 0.9)],
        **keys,
    }


def car(position, mass=60e3, pitch_inertia=0.8e6):
    return {"mass_kg": mass, "pitch_inertia_kg_m2": pitch_inertia, "position_m": position}


def by_parts(vehicle: Vehicle) -> Rake:
    """Return the vehicle of ten degrees of freedom, given by its parts."""
    middle = 0.5 * vehicle.length
    frames = [
        {
            "position_m": centre,
            "mass_kg": vehicle.bogie_mass,
            "pitch_inertia_kg_m2": vehicle.bogie_pitch_inertia,
            "secondary_stiffness_n_m": vehicle.secondary_stiffness,
            "secondary_damping_n_s_m": vehicle.secondary_damping,
            "axles": [
                axle(
                    centre + side * vehicle.axle_spacing / 2,
                    vehicle.axle_load,
                    vehicle.wheelset_mass,
                    vehicle.primary_stiffness,
                    vehicle.primary_damping,
                )
                for side in (-1, 1)
            ],
        }
        for centre in (middle - vehicle.bogie_spacing / 2, middle + vehicle.bogie_spacing / 2)
    ]
    composite = CompositeVehicle(
        length_m=vehicle.length,
        contact_stiffness_per_wheel_n_m=vehicle.contact_stiffness_per_wheel,
        car=car(middle, vehicle.car_mass, vehicle.car_pitch_inertia),
        bogies=frames,
    )
    return Rake((composite,))


def wagon(**keys):
    """A wagon on two bogies with rigid pivots, whose centre of gravity is off the middle."""
    return CompositeVehicle(
        **{"length_m": 14.0, **CONTACT, "car": car(6.4), "bogies": [bogie(2.5), bogie(11.5)], **keys}
    )


def two_axles(**keys):
    return CompositeVehicle(
        **{
            "length_m": 14.0,
            **CONTACT,
            "car": car(6.0, 36e3, 0.5e6),
            "axles": [axle(2.5, stiffness=3e6), axle(11.5, stiffness=3.4e6)],
            **keys,
        }
    )


def six_axles():
    frames = [
        bogie(c, axles=[axle(c + d) for d in (-1.8, 0.1, 1.9)], secondary_stiffness_n_m=2e6, pivot_m=c + 0.2)
        for c in (4.5, 15.0)
    ]
    return CompositeVehicle(length_m=19.5, **CONTACT, car=car(9.6, 80e3, 2e6), bogies=frames)


def articulated():
    """Two cars on three bogies; the middle one, asymmetric under both, is shared."""
    ahead = CompositeVehicle(
        length_m=18.7,
        **CONTACT,
        car=car(8.9, 22.5e3, 0.81e6),
        bogies=[
            bogie(0.5, secondary_stiffness_n_m=0.6e6, secondary_damping_n_s_m=20e3),
            bogie(18.6, secondary_stiffness_n_m=0.5e6, secondary_damping_n_s_m=15e3, pivot_m=18.5),
        ],
    )
    behind = CompositeVehicle(
        length_m=18.7,
        **CONTACT,
        car=car(9.1, 24e3, 0.9e6),
        bogies=[bogie(18.2, secondary_stiffness_n_m=0.6e6, secondary_damping_n_s_m=20e3)],
        on_vehicle_ahead={"position_m": 0.1, "stiffness_n_m": 0.4e6, "damping_n_s_m": 12e3},
    )
    return Rake((ahead, behind))


RAKES = {
    "wagon": Rake((wagon(),)),
    "two axles": Rake((two_axles(),)),
    "six axles": Rake((six_axles(),)),
    "articulated": articulated(),
}


@pytest.mark.parametrize("vehicle", [regina(), locomotive()], ids=["regina", "locomotive"])
def test_the_same_parts_are_the_vehicle_of_ten_degrees_of_freedom(vehicle):
    omega = np.concatenate([2.0 * np.pi * np.geomspace(0.01, 1000.0, 200), [-30.0]])
    expected = wheelset_receptance(vehicle, omega)
    size = np.abs(expected).max(axis=(1, 2), keepdims=True)
    rake = by_parts(vehicle)
    np.testing.assert_allclose(wheelset_receptance(rake, omega) / size, expected / size, rtol=0, atol=1e-12)
    np.testing.assert_allclose(rake.axle_positions, vehicle.axle_positions, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(rake.axle_loads, np.full(4, vehicle.axle_load))
    assert rake.total_mass == vehicle.total_mass


def test_shared_bogie_against_a_model_by_hand():
    """Two cars, three bogies, six wheelsets: 16 motions, seven primary and four secondary springs, with
    arms measured from the front of the leading car and displacements at s of w − s·φ.
    """
    bodies = [
        (22.5e3, 0.81e6, 8.9),
        (24e3, 0.9e6, 18.7 + 9.1),
        *((1800.0, 1700.0, s) for s in (0.5, 18.6, 18.7 + 18.2)),
    ]
    mass = np.diag([part for m, j, _s in bodies for part in (m, j)] + 6 * [1400.0])
    stiffness, damping = np.zeros((16, 16)), np.zeros((16, 16))

    def connect(s, upper, lower, k, c):
        elongation = np.zeros(16)
        elongation[2 * upper : 2 * upper + 2] = 1.0, -(s - bodies[upper][2])
        if lower < 5:
            elongation[2 * lower : 2 * lower + 2] = -1.0, s - bodies[lower][2]
        else:
            elongation[10 + lower - 5] = -1.0
        stiffness[:] += k * np.outer(elongation, elongation)
        damping[:] += c * np.outer(elongation, elongation)

    connect(0.5, 0, 2, 0.6e6, 20e3)
    connect(18.5, 0, 3, 0.5e6, 15e3)
    connect(18.8, 1, 3, 0.4e6, 12e3)
    connect(36.9, 1, 4, 0.6e6, 20e3)
    for number, s in enumerate((-0.4, 1.4, 17.7, 19.5, 36.0, 37.8)):
        connect(s, 2 + number // 2, 5 + number, 5.2e6, 30e3)
    for frequency in (0.05, 0.7, 2.0, 6.0, 20.0, 200.0):
        omega = 2.0 * np.pi * frequency
        dynamic = stiffness + 1j * omega * damping - omega**2 * mass
        expected = np.linalg.inv(dynamic)[10:, 10:][::-1, ::-1]  # receptances ascend with x
        np.testing.assert_allclose(
            wheelset_receptance(articulated(), omega), expected, rtol=0, atol=1e-9 * np.abs(expected).max()
        )


@pytest.mark.parametrize("rake", RAKES.values(), ids=RAKES)
def test_receptance_is_symmetric_and_passive(rake):
    omega = 2.0 * np.pi * np.geomspace(0.02, 500.0, 100)
    receptance = wheelset_receptance(rake, omega)
    np.testing.assert_array_equal(receptance, receptance.swapaxes(1, 2))
    np.testing.assert_allclose(wheelset_receptance(rake, -omega), receptance.conj(), rtol=1e-12)
    size = np.abs(receptance).max(axis=(1, 2))
    assert np.all(np.linalg.eigvalsh(receptance.imag).max(axis=1) < 1e-12 * size)


def stiffness_model(rake):
    """Return M, K and C of all bodies and wheelsets, assembled spring by spring from the front, and the
    wheelsets' motions, (axles, motions), in the order of the rake's axles; rigid joints are eliminated.
    """
    bodies, joints, axles = [], [], []
    front, last_bogie, last_car = 0.0, None, None
    for vehicle in rake.vehicles:
        number = len(bodies)
        bodies.append((vehicle.car.mass, vehicle.car.pitch_inertia, front + vehicle.car.position))
        axles += [(front + each.position, number, each) for each in vehicle.axles]
        if vehicle.support:
            under = last_bogie if vehicle.support.on == "bogie" else last_car
            joints.append(
                (
                    front + vehicle.support.position,
                    number,
                    under,
                    vehicle.support.stiffness,
                    vehicle.support.damping,
                )
            )
        for frame in vehicle.bogies:
            last_bogie = len(bodies)
            bodies.append((frame.mass, frame.pitch_inertia, front + frame.position))
            pivot = frame.position if frame.pivot is None else frame.pivot
            joints.append(
                (front + pivot, number, last_bogie, frame.secondary_stiffness, frame.secondary_damping)
            )
            axles += [(front + each.position, last_bogie, each) for each in frame.axles]
        front, last_car = front + vehicle.length, number
    axles.sort(key=lambda each: -each[0])
    motions = 2 * len(bodies) + len(axles)
    mass = np.diag(
        [part for m, j, _s in bodies for part in (m, j)] + [each.wheelset_mass for *_, each in axles]
    )
    stiffness, damping, rigid = np.zeros((motions, motions)), np.zeros((motions, motions)), []

    def at(body, s):
        row = np.zeros(motions)
        row[2 * body : 2 * body + 2] = 1.0, bodies[body][2] - s
        return row

    for s, upper, lower, k, c in joints:
        elongation = at(upper, s) - at(lower, s)
        if k is None:
            rigid.append(elongation)
        else:
            stiffness += k * np.outer(elongation, elongation)
            damping += (c or 0.0) * np.outer(elongation, elongation)
    wheelsets = np.eye(motions)[2 * len(bodies) :]
    for wheelset, (s, body, each) in zip(wheelsets, axles, strict=True):
        elongation = at(body, s) - wheelset
        stiffness += each.primary_stiffness * np.outer(elongation, elongation)
        damping += each.primary_damping * np.outer(elongation, elongation)
    free = scipy.linalg.null_space(np.array(rigid)) if rigid else np.eye(motions)
    return *(free.T @ matrix @ free for matrix in (mass, stiffness, damping)), wheelsets @ free


@pytest.mark.parametrize("rake", RAKES.values(), ids=RAKES)
@pytest.mark.parametrize("frequency", [0.05, 1.0, 4.0, 30.0, 300.0])
def test_against_stiffness_matrices(rake, frequency):
    """1e-8: at low frequency the matrices lose the digits that the rake keeps."""
    mass, stiffness, damping, wheelsets = stiffness_model(rake)
    omega = 2.0 * np.pi * frequency
    dynamic = stiffness + 1j * omega * damping - omega**2 * mass
    expected = wheelsets @ np.linalg.solve(dynamic, wheelsets.T)
    receptance = wheelset_receptance(rake, omega)
    np.testing.assert_allclose(receptance, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("rake", RAKES.values(), ids=RAKES)
def test_rigid_body_limit(rake):
    """Slow forces move what no spring holds: bounce and pitch of the whole, and pitch of every bogie. The
    remainder falls with the square of the frequency.
    """
    mass, stiffness, _damping, wheelsets = stiffness_model(rake)
    values, vectors = scipy.linalg.eigh(stiffness, mass)
    held = values > 1e-6 * values.max()
    bogies = sum(len(vehicle.bogies) for vehicle in rake.vehicles)
    # Two motions per body, less one per joint.
    assert (~held).sum() == len(rake.vehicles) + bogies + 1
    moved = wheelsets @ vectors[:, ~held]
    expected = -moved @ moved.T
    error = [
        np.abs(omega**2 * wheelset_receptance(rake, omega) - expected).max() / np.abs(expected).max()
        for omega in (0.1, 0.01)
    ]
    assert error[0] < 1e-2
    assert error[1] < 0.02 * error[0] + 1e-11


def test_two_axles_move_as_one_body():
    """−1/(Mω²) of bounce, and of pitch as far as the axles are from the centre of gravity."""
    rake = RAKES["two axles"]
    parts = [(36e3, 6.0), (1400.0, 2.5), (1400.0, 11.5)]
    mass = sum(m for m, _s in parts)
    centre = sum(m * s for m, s in parts) / mass
    inertia = 0.5e6 + sum(m * (s - centre) ** 2 for m, s in parts)
    arm = np.array([11.5, 2.5]) - centre
    omega = 1e-2
    expected = -(1.0 / mass + np.outer(arm, arm) / inertia) / omega**2
    np.testing.assert_allclose(wheelset_receptance(rake, omega), expected, rtol=1e-5)


def test_one_stage_is_a_very_stiff_second_stage():
    """What is left of the second stage is as its flexibility: ten times stiffer, a tenth."""
    omega = 2.0 * np.pi * np.array([0.5, 3.0, 10.0, 80.0])
    expected = wheelset_receptance(RAKES["wagon"], omega)
    error = []
    for stiffness in (1e11, 1e12):
        frames = [bogie(centre, secondary_stiffness_n_m=stiffness) for centre in (2.5, 11.5)]
        stiff = wheelset_receptance(Rake((wagon(bogies=frames),)), omega)
        error.append((np.abs(stiff - expected).max(axis=(1, 2)) / np.abs(expected).max(axis=(1, 2))).max())
    assert error[0] < 1e-2
    assert error[0] / error[1] == pytest.approx(10.0, rel=0.02)


@pytest.mark.parametrize("rake", [by_parts(regina()), *RAKES.values()], ids=["regina", *RAKES])
def test_suspension_modes_are_eigenvalues_on_held_wheelsets(rake):
    mass, stiffness, damping, wheelsets = stiffness_model(rake)
    held = scipy.linalg.null_space(wheelsets)
    mass, stiffness, damping = (held.T @ matrix @ held for matrix in (mass, stiffness, damping))
    modes = rake.suspension_modes
    assert np.all(modes.real <= 0.0)
    for mode in modes:
        dynamic = mode**2 * mass + mode * damping + stiffness
        scale = np.sqrt(np.diag(np.abs(mode) ** 2 * mass + stiffness))
        values = scipy.linalg.svdvals(dynamic / scale[:, None] / scale)
        assert values[-1] < 1e-9 * values[0]
    undamped = np.sqrt(scipy.linalg.eigvalsh(stiffness, mass))
    light = [np.abs(mode) for mode in modes if abs(mode.real) < 0.1 * mode.imag]
    assert all(np.abs(undamped / mode - 1.0).min() < 0.05 for mode in light)


@pytest.mark.parametrize("rake", RAKES.values(), ids=RAKES)
def test_axle_loads_are_the_weight(rake):
    loads = rake.weights_on_axles
    np.testing.assert_array_equal(rake.axle_loads, np.round(loads, 6))
    assert loads.sum() == pytest.approx(GRAVITY * rake.total_mass, rel=1e-12)
    assert np.all(loads > 0.0)
    # Moments about the rear end.
    moment, front = 0.0, rake.length
    for vehicle in rake.vehicles:
        parts = [(vehicle.car.mass, vehicle.car.position)]
        parts += [(each.mass, each.position) for each in vehicle.bogies]
        parts += [(each.wheelset_mass, each.position) for each in vehicle.all_axles()]
        moment += GRAVITY * sum(mass * (front - position) for mass, position in parts)
        front -= vehicle.length
    assert loads @ rake.axle_positions == pytest.approx(moment, rel=1e-12)


def test_axle_loads_by_the_lever():
    loads = RAKES["two axles"].weights_on_axles
    car_weight = 36e3 * GRAVITY
    front = car_weight * (11.5 - 6.0) / 9.0 + 1400.0 * GRAVITY
    np.testing.assert_allclose(loads, [car_weight + 2800.0 * GRAVITY - front, front], rtol=1e-12)


def test_a_given_axle_load_is_taken():
    rake = Rake((two_axles(axles=[axle(2.5, load=190e3), axle(11.5)]),))
    assert rake.axle_loads[1] == 190e3
    assert rake.loads_are_given
    assert not RAKES["two axles"].loads_are_given


def test_a_car_hangs_between_two_others():
    """A module without axles, as of low-floor trams: its weight is on the neighbours."""
    head = CompositeVehicle(
        length_m=6.0,
        **CONTACT,
        car=car(3.0, 10e3, 3e4),
        bogies=[bogie(3.0, axles=[axle(2.1), axle(3.9)], secondary_stiffness_n_m=1e6)],
    )
    hanging = CompositeVehicle(
        length_m=7.0, **CONTACT, car=car(3.5, 8e3, 3e4), on_vehicle_ahead={"position_m": 0.0, "on": "car"}
    )
    tail = head.model_copy(update={"support": hanging.support})
    with pytest.raises(InputError, match=r"vehicles\[0\]: does not stand"):
        Rake((head, hanging, tail)).check([f".vehicles[{i}]" for i in range(3)])
    pair = [bogie(c, secondary_stiffness_n_m=1e6) for c in (1.5, 4.5)]
    on_two = [each.model_copy(update={"bogies": wagon(bogies=pair).bogies}) for each in (head, tail)]
    rake = Rake((on_two[0], hanging, on_two[1]))
    rake.check([f".vehicles[{i}]" for i in range(3)])
    assert rake.axle_loads.sum() == pytest.approx(GRAVITY * rake.total_mass)
    np.testing.assert_array_equal(rake.axle_vehicles, [2] * 4 + [0] * 4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"car": car(20.0)}, r"car\.position_m = 20 m: must be at most length_m = 14 m"),
        ({"bogies": []}, r"bogies: is missing; a car stands on bogies, axles or the vehicle ahead"),
        (
            {"bogies": [bogie(2.5), bogie(30.0)]},
            r"bogies\[1\]\.position_m = 30 m: must be at most 10 m beyond",
        ),
        (
            {"bogies": [bogie(2.5, secondary_damping_n_s_m=1e4)]},
            r"bogies\[0\]\.secondary_damping_n_s_m: needs secondary_stiffness_n_m",
        ),
        (
            {"bogies": [bogie(2.5, axles=[axle(2.5, stiffness=-1.0)])]},
            r"bogies\[0\]\.axles\[0\]\.primary_stiffness_n_m = -1\.0 N/m: should be greater",
        ),
        ({"bogies": [bogie(2.5, weight_kg=1.0)]}, r"bogies\[0\]\.weight_kg: unknown key"),
        ({"on_vehicle_ahead": {"position_m": 0.0, "on": "roof"}}, r"on = 'roof': should be 'bogie' or 'car'"),
    ],
)
def test_refused(change, message):
    with pytest.raises(InputError, match=message):
        wagon(**change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bogies": [bogie(2.5)]}, r"^\.here: does not stand"),
        (
            {"bogies": [bogie(2.5), bogie(4.3)]},
            r"^\.here: an axle at position_m = 3\.4 m stands where another",
        ),
        ({"car": car(1.0), "bogies": [bogie(7.0), bogie(11.5)]}, r"at position_m = 12\.4 m would lift off"),
    ],
)
def test_rakes_that_do_not_stand(change, message):
    with pytest.raises(InputError, match=message):
        Rake((wagon(**change),)).check([".here"])
