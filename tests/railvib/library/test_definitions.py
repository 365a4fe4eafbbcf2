"""Definitions of a study become objects, before the library's; wrong ones are refused with their place."""

import tomllib

import numpy as np
import pytest

from railvib import library
from railvib.errors import InputError, PlausibilityWarning
from railvib.parameters.composite_vehicle import CompositeVehicle
from railvib.parameters.vehicle import Train, Vehicle

STUDY = tomllib.loads("""
[vehicle.short]
title = "a vehicle of the study"
car_mass_kg = 40000
car_pitch_inertia_kg_m2 = 2e6
bogie_mass_kg = 5000
bogie_pitch_inertia_kg_m2 = 6000
wheelset_mass_kg = 1800
primary_stiffness_n_m = 2.4e6
primary_damping_n_s_m = 30e3
secondary_stiffness_n_m = 0.6e6
secondary_damping_n_s_m = 20e3
axle_spacing_m = 2.7
bogie_spacing_m = 12
length_m = 18
axle_load_n = 140100
contact_stiffness_per_wheel_n_m = 1.4625e9
[train.single]
vehicle = "short"
number = 3
[train.mixed]
source = "invented"
vehicles = [{ vehicle = "short" }, { vehicle = "regina", number = 2 }, "velaro-e"]
[[train.tables]]
vehicle = "regina"
[[train.tables]]
vehicle = "short"
number = 2
[soil.greby]
layers = [{ shear_speed_m_s = 200, dilatational_speed_m_s = 400, density_kg_m3 = 1800, loss_factor = 0.1 }]
""")


def test_definitions_of_a_study_stand_before_the_library():
    short, regina = library.resolve("vehicle", "short", STUDY), library.load("vehicle", "regina")
    assert library.resolve("train", "single", STUDY).vehicles == (short,) * 3
    assert library.resolve("train", "mixed", STUDY).vehicles == (
        short,
        regina,
        regina,
        library.load("vehicle", "velaro-e"),
    )
    assert library.resolve("train", "tables", STUDY).vehicles == (regina, short, short)
    assert library.resolve("soil", "greby", STUDY).layers[0].shear_speed == 200.0
    assert library.resolve("soil", "horstwalde", STUDY) == library.load("soil", "horstwalde")
    with pytest.raises(InputError, match=r"train = 'mixt': is unknown; the nearest known is 'mixed'"):
        library.resolve("train", "mixt", STUDY)


def test_resolved_form_of_a_train_resolves_to_itself():
    train = library.resolve("train", "mixed", STUDY)
    assert library.resolve_train(train.model_dump(by_alias=True)) == train
    assert library.resolve_train([train.vehicles[0].model_dump(by_alias=True)]).vehicles == train.vehicles[:1]


def test_a_vehicle_may_be_defined_in_its_place():
    vehicle = STUDY["vehicle"]["short"]
    inside = library.resolve_train({"vehicle": vehicle, "number": 2})
    assert inside == library.resolve_train({**vehicle, "number": 2})
    assert isinstance(inside.vehicles[0], Vehicle)


@pytest.mark.parametrize(
    ("definition", "message"),
    [
        (
            {"vehicle": "regin"},
            r"^train\.x\.vehicle: vehicle = 'regin': is unknown; the nearest known is 'regina'",
        ),
        ({"vehicle": "regina", "number": 0}, r"^train\.x\.number = 0: must be a whole number from 1"),
        ({"vehicle": "regina", "number": 2.5}, r"^train\.x\.number = 2\.5"),
        ({"vehicle": "regina", "number": True}, r"^train\.x\.number = True"),
        ({"vehicle": "regina", "number": 1001}, r"^train\.x\.number = 1001: must be .* from 1 to 1000"),
        ({"vehicle": "regina", "number": 10**18}, r"^train\.x\.number = 1000000000000000000: must be"),
        ({"vehicle": "regina", "number": 10**5000}, r"^train\.x\.number = int too large to show"),
        (["regina"] * 1001, r"^train\.x: more than 1000 vehicles"),
        ([{"vehicle": "regina", "number": 600}] * 2, r"^train\.x: more than 1000 vehicles"),
        ({"vehicle": "regina", "numbers": 2}, r"^train\.x\.numbers: unknown key"),
        ({"vehicles": []}, r"^train\.x\.vehicles = \[\]: must be a list of at least one vehicle"),
        ({"vehicles": ["regina"], "number": 2}, r"^train\.x\.number: unknown key beside vehicles"),
        ({"vehicles": ["regina", 7]}, r"^train\.x\.vehicles\[1\] = 7"),
        ("regina", r"^train\.x = 'regina': must be a list"),
        (
            [{"vehicle": {"car_mass_kg": -1}}],
            r"^train\.x\[0\]\.vehicle\.car_mass_kg = -1 kg: should be greater",
        ),
    ],
)
def test_refused_trains(definition, message):
    with pytest.raises(InputError, match=message):
        library.build("train", definition, where="train.x")


def test_messages_begin_with_the_name_in_the_study():
    layer = {"shear_speed_m_s": 200, "dilatational_speed_m_s": 400, "density_kg_m3": -1, "loss_factor": 0.1}
    with pytest.raises(InputError, match=r"^soil\.mine\.layers\[0\]\.density_kg_m3 = -1"):
        library.resolve("soil", "mine", {"soil": {"mine": {"layers": [layer]}}})
    with pytest.raises(InputError, match=r"^soil\.mine = 3: must be a table"):
        library.resolve("soil", "mine", {"soil": {"mine": 3}})


def test_a_vehicle_whose_load_does_not_fit_is_named_once():
    heavy = {"heavy": {**STUDY["vehicle"]["short"], "axle_load_n": 300e3}}
    with pytest.warns(PlausibilityWarning, match=r"^vehicle\.heavy\.axle_load_n = 300000 N") as caught:
        library.build("train", {"vehicle": "heavy", "number": 9}, where="train.x", vehicles=heavy)
    assert len(caught) == 1


PARTS = tomllib.loads("""
[vehicle.wagon]
length_m = 14
contact_stiffness_per_wheel_n_m = 1.4e9
car = { mass_kg = 36000, pitch_inertia_kg_m2 = 5e5, position_m = 7 }
[[vehicle.wagon.axles]]
position_m = 2.5
wheelset_mass_kg = 1400
primary_stiffness_n_m = 3.2e6
primary_damping_n_s_m = 4e4
[[vehicle.wagon.axles]]
position_m = 11.5
wheelset_mass_kg = 1400
primary_stiffness_n_m = 3.2e6
primary_damping_n_s_m = 4e4
[vehicle.behind]
length_m = 10
contact_stiffness_per_wheel_n_m = 1.4e9
car = { mass_kg = 9000, pitch_inertia_kg_m2 = 5e4, position_m = 5 }
on_vehicle_ahead = { position_m = -0.5, on = "car" }
[[vehicle.behind.axles]]
position_m = 9
wheelset_mass_kg = 1400
primary_stiffness_n_m = 3.2e6
primary_damping_n_s_m = 4e4
""")["vehicle"]


def test_a_vehicle_by_parts_in_a_study():
    wagon = library.build("vehicle", PARTS["wagon"], where="vehicle.wagon")
    assert isinstance(wagon, CompositeVehicle)
    train = library.build("train", ["regina", {"vehicle": "wagon", "number": 2}, "behind"], vehicles=PARTS)
    assert isinstance(train, Train)
    assert train.axle_count == 4 + 2 * 2 + 1
    np.testing.assert_array_equal(train.axle_vehicles[::-1], [1, 1, 1, 1, 2, 2, 3, 3, 4])
    assert [block.axle_count for block in train.blocks] == [4, 2, 3]
    again = library.resolve_train(train.model_dump(by_alias=True, exclude_none=True))
    assert again == train


def heavier(**loads):
    axles = [{**axle, **loads} for axle in PARTS["wagon"]["axles"]]
    return {**PARTS, "wagon": {**PARTS["wagon"], "axles": axles}}


def test_axle_loads_of_parts_that_do_not_fit_their_masses():
    with pytest.warns(
        PlausibilityWarning, match=r"^train\[1\]: axle_load_n of 2 axles are 3e\+04 N"
    ) as caught:
        library.build("train", ["regina", "wagon"], vehicles=heavier(axle_load_n=15e3))
    assert len(caught) == 1
    library.build("train", ["regina", "wagon"], vehicles=heavier(axle_load_n=190e3))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"axles": []}, r"^vehicle\.x\.bogies: is missing; a car stands on bogies, axles or"),
        (
            {"car": {"mass_kg": -1}},
            r"^vehicle\.x\.car\.mass_kg = -1 kg: should be greater than or equal to 100 kg",
        ),
        ({"car": {"mass_t": 36}}, r"^vehicle\.x\.car\.mass_t: unknown key; give mass_kg = 36000 kg"),
        ({"boggies": []}, r"^vehicle\.x\.boggies: unknown key; did you mean bogies\?"),
        ({"axle_load_n": 1e5}, r"^vehicle\.x\.axle_load_n: unknown key; it is a key of axles"),
    ],
)
def test_refused_parts(change, message):
    with pytest.raises(InputError, match=message):
        library.build("vehicle", {**PARTS["wagon"], **change}, where="vehicle.x")


@pytest.mark.parametrize(
    ("vehicles", "message"),
    [
        (["behind"], r"^train\.x\[0\]\.on_vehicle_ahead: needs a vehicle ahead that is given by its parts"),
        (["regina", "behind"], r"^train\.x\[1\]\.on_vehicle_ahead: needs a vehicle ahead"),
        (
            ["wagon", {**PARTS["behind"], "on_vehicle_ahead": {"position_m": 0}}],
            r'^train\.x\[1\]\.on_vehicle_ahead\.on = "bogie": the vehicle ahead has none',
        ),
        ([{**PARTS["wagon"], "axles": PARTS["wagon"]["axles"][:1]}], r"^train\.x\[0\]: does not stand"),
        (
            [
                "wagon",
                {
                    **PARTS["wagon"],
                    "axles": [{**PARTS["wagon"]["axles"][0], "position_m": -3}, PARTS["wagon"]["axles"][1]],
                },
            ],
            r"^train\.x\[1\]: its leading axle lies ahead of an axle of the vehicle ahead",
        ),
    ],
)
def test_refused_trains_of_parts(vehicles, message):
    with pytest.raises(InputError, match=message):
        library.build("train", vehicles, where="train.x", vehicles=PARTS)
