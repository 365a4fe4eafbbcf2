"""What a prediction from Python warns about, with the path of each value."""

import warnings

import pytest

from railvib import library
from railvib.errors import InputError, PlausibilityWarning
from railvib.parameters.ground import Ground
from railvib.parameters.units import KMH
from railvib.plausibility import check_inputs

GREBY = library.load("soil", "greby")


def test_the_papers_case_is_plausible(track):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_inputs(GREBY, track, 150.0 / KMH)


def test_every_unusual_value_is_named(track):
    light = Ground(layers=[layer.model_copy(update={"density": 1.8}) for layer in GREBY.layers])
    one_rail = track.model_copy(update={"rail_mass": 60.0})
    with pytest.warns(PlausibilityWarning) as caught:
        check_inputs(light, one_rail, 150.0 / KMH)
    assert [str(warning.message).partition(":")[0] for warning in caught] == [
        "ground.layers[0].density_kg_m3 = 1.8 kg/m³",
        "ground.layers[1].density_kg_m3 = 1.8 kg/m³",
        "ground.layers[2].density_kg_m3 = 1.8 kg/m³",
        "track.rail_mass_kg_m = 60 kg/m",
    ]


@pytest.mark.parametrize("speed", [-40.0, 0.0, 1e-3, 3e8, float("nan")])
def test_speeds_of_no_train_are_refused(track, speed):
    with pytest.raises(InputError, match=r"^speed = .* m/s: must be from 0.278 to 278 m/s, 1 to 1000 km/h$"):
        check_inputs(GREBY, track, speed)
