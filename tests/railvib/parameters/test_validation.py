"""What holds for every parameter: a range with a unit, numbers that are numbers, one line for every fault."""

import re
import warnings

import numpy as np
import pytest

from railvib.errors import InputError, PlausibilityWarning
from railvib.library import entry
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.track import Track, TrackLayer
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import unit_of
from railvib.parameters.validation import validated, without_cautions
from railvib.parameters.vehicle import Train, Vehicle

LAYER = {
    "shear_speed_m_s": 150.0,
    "dilatational_speed_m_s": 300.0,
    "density_kg_m3": 1800.0,
    "loss_factor": 0.1,
}
BALLASTED = dict(entry("track", "ballasted-paper").parameters)
SLAB = dict(entry("track", "slab-example").parameters)
REGINA = dict(entry("vehicle", "regina").parameters)
TABLE = {"form": "table", "wavelength_m": [8.0, 2.0], "level_db": [30.0, 20.0]}
DENSITIES = {"form": "table", "wavelength_m": [8.0, 2.0], "spectral_density_m3": [1e-6, 1e-7]}
CUT = {"form": "german-low", "minimum_wavelength_m": 1.0, "maximum_wavelength_m": 90.0}
OBJECTS = [
    (Layer, {**LAYER, "thickness_m": 2.0}),
    (TrackLayer, BALLASTED["layers"][0]),
    (Track, BALLASTED),
    (Track, SLAB),
    (Vehicle, REGINA),
    (CrossSection, {"layer_height_m": 0.3, "poisson_ratio": 0.2, "elements": 8, "rows": 3}),
    (Unevenness, {"form": "fra-av", "line_class": 3}),
    (Unevenness, {"form": "power-law", "amplitude_m3": 1e-8, "exponent": 3.0}),
    (Unevenness, TABLE),
    (Unevenness, DENSITIES),
    (Unevenness, CUT),
]
NUMBERS = [
    (model, table, key)
    for model, table in OBJECTS
    for key, value in table.items()
    if isinstance(value, int | float) or (isinstance(value, list) and isinstance(value[0], float))
]
NO_NUMBERS = [True, "3.0", b"3.0", np.True_, [3.0], {"value": 3.0}, 1 + 2j]
BEYOND = [-1e300, 1e300, float("nan"), float("inf"), 2**53 + 1, 10**400, 10**5000]


def refusal(model, table):
    """Return the message of a refused table; nothing else is an error, and nothing comes of it."""
    with pytest.raises(InputError) as caught, without_cautions():
        model(**table)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 500
    return message


def replaced(table, key, value):
    """Return a table with one number replaced, in a list its first."""
    return {**table, key: [value, *table[key][1:]] if isinstance(table[key], list) else value}


@pytest.mark.parametrize("value", BEYOND, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize(("model", "table", "key"), NUMBERS)
def test_every_number_has_a_range(model, table, key, value):
    message = refusal(model, replaced(table, key, value))
    assert message.startswith(f"{model.__name__}.{key}")
    assert unit_of(key) in message
    assert "should be" in message


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
@pytest.mark.parametrize(("model", "table", "key"), NUMBERS)
def test_what_is_no_number_is_refused(model, table, key, value):
    assert refusal(model, replaced(table, key, value)).startswith(f"{model.__name__}.{key}")


@pytest.mark.parametrize("number", [np.float64(1800.0), np.float32(1800.0), np.int64(1800), 1800])
def test_numbers_of_numpy_are_numbers(number):
    assert Layer(**{**LAYER, "density_kg_m3": number}) == Layer(**LAYER)


@pytest.mark.parametrize(
    ("model", "table", "message"),
    [
        (Layer, {**LAYER, "density_kg_m3": -1}, "Layer.density_kg_m3 = -1 kg/m³: should be greater"),
        (Ground, {"layers": [{**LAYER, "density_kg_m3": -1}]}, "Ground.layers[0].density_kg_m3 = -1 kg/m³"),
        (Ground, {"layers": []}, "Ground.layers = []: must have at least one value"),
        (Ground, {"layers": 3}, "Ground.layers = 3: must be a list"),
        (Ground, {"layers": [3]}, "Ground.layers[0] = 3: must be a table"),
        (Ground, {"layers": [LAYER] * 201}, "must have at most 200 values"),
        (Ground, {"layers": [{"density": 1800.0}]}, "Ground.layers[0].shear_speed_m_s: is missing"),
        (
            Ground,
            {"layers": [{"los_factor": 0.1}]},
            "layers[0].los_factor: unknown key; did you mean loss_factor?",
        ),
        (Ground, {"layers": [LAYER], "self": 3}, "Ground.self: unknown key; known are base, layers"),
        (Ground, {"layers": [LAYER], "density_kg_m3": 3}, "unknown key; it is a key of layers"),
        (Ground, {"layers": [LAYER], "k" * 10**6: 3}, "known are base, layers"),
        (Ground, {"layers": [LAYER], "base": "b" * 10**6}, "should be 'half-space' or 'rigid'"),
        (Ground, {"layers": [LAYER], "\x1b[31m": 1}, r"Ground.\x1b[31m: unknown key"),
        (Train, {"vehicles": [REGINA] * 1001}, "must have at most 1000 values"),
    ],
)
def test_a_fault_is_one_line(model, table, message):
    assert message in refusal(model, table)


UNUSUAL = [
    (
        Ground,
        {"layers": [{**LAYER, "density_kg_m3": 1.75}]},
        r"^layers\[0\]\.density_kg_m3 = 1\.75 kg/m³: soil",
    ),
    (
        Ground,
        {"layers": [{**LAYER, "density_kg_m3": 3600}]},
        r"^layers\[0\]\.density_kg_m3 = 3600 kg/m³: soil",
    ),
    (
        Track,
        {**BALLASTED, "rail_bending_stiffness_n_m2": 6.4e6},
        r"^rail_bending_stiffness_n_m2 = 6\.4e\+06 N·m²",
    ),
    (
        Track,
        {**BALLASTED, "rail_mass_kg_m": 60},
        r"^rail_mass_kg_m = 60 kg/m: .* one rail; give that of both",
    ),
    (Vehicle, {**REGINA, "axle_load_n": 14e3}, r"^axle_load_n = 14000 N: the four axles carry"),
    (Train, {"vehicles": [{**REGINA, "axle_load_n": 14e3}]}, r"^vehicles\[0\]\.axle_load_n = 14000 N"),
]


@pytest.mark.parametrize(("model", "table", "message"), UNUSUAL)
def test_what_is_unusual_is_warned_about_with_its_key(model, table, message):
    with pytest.warns(PlausibilityWarning, match=message.replace("^", r"^soil\.mine\.")) as caught:
        thing = validated(model, table, "soil.mine")
    assert len(caught) == 1
    (text,) = thing.cautions()
    assert re.match(message, text)


@pytest.mark.parametrize("density", [500.0, 3500.0])
def test_what_is_usual_is_not_warned_about(density):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        validated(Ground, {"layers": [{**LAYER, "density_kg_m3": density}]})
        validated(Track, BALLASTED)
        validated(Vehicle, REGINA)
