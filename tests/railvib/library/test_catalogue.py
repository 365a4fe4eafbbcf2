"""The library: every entry loads and names its sources."""

import csv

import numpy as np
import pytest

from railvib import library
from railvib.errors import InputError
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import GRAVITY
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
        ("track", "qqqqq", "known are ballasted-mean, ballasted-paper, slab-example"),
        ("soils", "greby", "kind = 'soils': must be one of soil, track"),
    ],
)
def test_unknown_names(kind, name, message):
    with pytest.raises(InputError, match=message):
        library.load(kind, name)


# Half a vehicle (one rail), SI units; distances are half of those between bogies and between axles. Source:
# default trains of STEM 1.4.0, its documentation of loads, which names "Ricardo 2025".
STEM = """
name,cart_mass,bogie_mass,wheel_mass,cart_inertia,bogie_inertia,secondary_stiffness,secondary_damping,primary_stiffness,primary_damping,half_bogie_distance,half_wheel_distance,length
locomotive,27500,3000,2250,485000.0,3900,800000.0,45000.0,2000000.0,33000.0,10.4,1.3,26.8
passenger-heavy,19000,1550,950,1150000.0,1200,350000.0,32000.0,1200000.0,2500.0,10,1.25,27
passenger-light,14500,1300,850,900000.0,1150,400000.0,22000.0,740000.0,6400.0,9.5,1.28,25
freight-loaded,40500,900,700,365000.0,850,6000000.0,65000.0,2600000.0,15000.0,7,0.9,17
freight-unloaded,6500,900,700,115000.0,850,6000000.0,65000.0,500000.0,5700.0,7,0.9,17
"""


@pytest.mark.parametrize("row", list(csv.DictReader(STEM.split())), ids=lambda row: row["name"])
def test_trains_of_stem_are_twice_their_half_models(row):
    vehicle = library.load("vehicle", f"stem-{row['name']}")
    half = {key: float(value) for key, value in row.items() if key != "name"}
    assert isinstance(vehicle, Vehicle)
    assert (vehicle.car_mass, vehicle.car_pitch_inertia) == (2 * half["cart_mass"], 2 * half["cart_inertia"])
    assert (vehicle.bogie_mass, vehicle.bogie_pitch_inertia) == (
        2 * half["bogie_mass"],
        2 * half["bogie_inertia"],
    )
    assert vehicle.wheelset_mass == 2 * half["wheel_mass"]
    for stage in ("primary", "secondary"):
        assert getattr(vehicle, f"{stage}_stiffness") == 2 * half[f"{stage}_stiffness"]
        assert getattr(vehicle, f"{stage}_damping") == 2 * half[f"{stage}_damping"]
    assert (vehicle.bogie_spacing, vehicle.axle_spacing, vehicle.length) == (
        2 * half["half_bogie_distance"],
        2 * half["half_wheel_distance"],
        half["length"],
    )
    assert f"stem-{row['name']}" in library.names("train")


@pytest.mark.parametrize("name", library.names("train"))
def test_axles_of_every_train_carry_its_weight(name):
    """To 0.2 %: where axle loads are given, they are rounded."""
    train = library.load("train", name)
    weight = GRAVITY * sum(vehicle.total_mass for vehicle in train.vehicles)
    assert train.axle_loads.sum() == pytest.approx(weight, rel=2e-3)
    assert np.all((train.axle_loads > 40e3) & (train.axle_loads < 230e3))


def test_half_a_eurostar():
    train = library.load("train", "eurostar-half")
    assert train.length == pytest.approx(196.86)
    assert train.axle_count == 24
    power_car, trailers = train.blocks
    assert power_car.axle_count == 4
    assert trailers.axle_count == 20
    # Bogies of neighbouring trailers, and of the power car and the first trailer.
    behind = train.axle_positions[-1] - train.axle_positions[::-1]
    np.testing.assert_allclose(behind[[2, 4, 6, 8, 22]], [14.0, 20.275, 38.975, 57.675, 188.575])
    assert train.axle_loads.max() < 17.1e3 * GRAVITY
