"""The library: every entry loads and names its sources; definitions of studies."""

import tomllib

import pytest

from railvib import library
from railvib.errors import InputError
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.validation import Parameters
from railvib.parameters.vehicle import Train, Vehicle

EVERYTHING = [(kind, name) for kind in library.KINDS for name in library.names(kind)]


@pytest.mark.parametrize(("kind", "name"), EVERYTHING)
def test_every_entry_loads_and_has_its_sources(kind, name):
    assert isinstance(library.load(kind, name), Parameters)
    entry = library.entry(kind, name)
    assert entry.title
    assert entry.source
    assert set(entry.sources) <= set(entry.parameters)
    assert all(entry.source_of(key) for key in entry.parameters)


def test_names_of_the_study():
    assert {"horstwalde", "greby"} <= set(library.names("soil"))
    assert "ballasted-paper" in library.names("track")
    assert "grona-taget" in library.names("train")
    assert "regina" in library.names("vehicle")
    for family in ("fra-hamid-yang", "fra-av"):
        assert {f"{family}-{c}" for c in range(1, 7)} <= set(library.names("unevenness"))


def test_soils_of_the_paper():
    horstwalde = library.load("soil", "horstwalde")
    assert isinstance(horstwalde, Ground)
    (half_space,) = horstwalde.layers
    assert (half_space.shear_speed, half_space.dilatational_speed) == (250.0, 1470.0)
    assert (half_space.density, half_space.loss_factor) == (1945.0, 0.05)
    greby = library.load("soil", "greby")
    assert [layer.thickness for layer in greby.layers] == [2.0, 2.0, None]
    assert [layer.shear_speed for layer in greby.layers] == [103.36, 122.30, 310.09]
    assert [layer.dilatational_speed for layer in greby.layers] == [193.37, 228.80, 580.12]
    assert [layer.density for layer in greby.layers] == [1800.0, 1800.0, 2000.0]
    assert {layer.loss_factor for layer in greby.layers} == {0.2}


def test_track_of_the_paper():
    track = library.load("track", "ballasted-paper")
    assert isinstance(track, Track)
    (ballast,) = track.layers
    assert (track.rail_bending_stiffness, track.rail_mass, track.rail_loss_factor) == (12.8e6, 120.0, 0.01)
    assert (track.pad_stiffness, track.pad_loss_factor, track.sleeper_mass) == (1000e6, 0.1, 542.0)
    assert (ballast.stiffness, ballast.mass, ballast.loss_factor) == (4640e6, 1740.0, 0.04)
    assert track.contact_width == 3.2


def test_train_of_the_paper():
    train = library.load("train", "grona-taget")
    assert isinstance(train, Train)
    assert train.vehicles == (library.load("vehicle", "regina"),) * 4
    assert train.length == pytest.approx(106.4)
    (regina, *_) = train.vehicles
    assert (regina.car_mass, regina.bogie_mass, regina.wheelset_mass) == (40e3, 5e3, 1.8e3)
    assert (regina.car_pitch_inertia, regina.bogie_pitch_inertia) == (2e6, 6e3)
    assert (regina.primary_stiffness, regina.primary_damping) == (2.4e6, 30e3)
    assert (regina.secondary_stiffness, regina.secondary_damping) == (0.6e6, 20e3)
    assert (regina.axle_spacing, regina.bogie_spacing, regina.length) == (2.7, 19.0, 26.6)
    assert (regina.axle_load, regina.contact_stiffness) == (140.1e3, 2 * 1462.5e6)


def test_names_of_unevenness_say_form_and_class():
    for name in library.names("unevenness"):
        unevenness = library.load("unevenness", name)
        assert isinstance(unevenness, Unevenness)
        suffix = f"-{unevenness.line_class}" if unevenness.line_class else ""
        assert name == unevenness.form + suffix


@pytest.mark.parametrize(
    ("kind", "name", "message"),
    [
        ("soil", "grebi", r"soil = 'grebi': is unknown; the nearest known is 'greby'"),
        ("train", "grona taget", "the nearest known is 'grona-taget'"),
        ("unevenness", "fra-hamid-yang-7", "the nearest known is 'fra-hamid-yang-"),
        ("track", "qqqqq", "known are ballasted-paper, slab-example"),
        ("soils", "greby", "kind = 'soils': must be one of soil, track"),
    ],
)
def test_unknown_names(kind, name, message):
    with pytest.raises(InputError, match=message):
        library.load(kind, name)


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
        ({"vehicle": "regina", "numbers": 2}, r"^train\.x\.numbers: unknown key"),
        ({"vehicles": []}, r"^train\.x\.vehicles = \[\]: must be a list of at least one vehicle"),
        ({"vehicles": ["regina"], "number": 2}, r"^train\.x\.number: unknown key beside vehicles"),
        ({"vehicles": ["regina", 7]}, r"^train\.x\.vehicles\[1\] = 7"),
        ("regina", r"^train\.x = 'regina': must be a list"),
        ([{"vehicle": {"car_mass_kg": -1}}], r"^train\.x\[0\]\.vehicle\.car_mass_kg = -1: should be greater"),
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
