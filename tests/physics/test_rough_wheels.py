"""Wheels out of round: laws of incoherent excitation by moving roughness and by the full model."""

import numpy as np
import pytest

from railvib import library, predict, predict_passage
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.parameters.wheel_roughness import WheelRoughness

AMPLITUDE = {"amplitude": 1e-9, "exponent": 2.5}
RAILS = Unevenness(form="power-law", **AMPLITUDE)
WHEELS = WheelRoughness(form="power-law", circumference=10.0, **AMPLITUDE)
"""The same spectrum at all wavelengths of the bands."""
MOVING = ("moving-roughness", "moving-roughness-by-axle", "moving-roughness-uncorrelated")


@pytest.fixture(scope="module")
def rough(vehicle):
    """A vehicle with rough wheels before a smooth one of another make."""
    return Train(
        vehicles=[
            vehicle.model_copy(update={"wheel_roughness": WHEELS}),
            library.load("vehicle", "two-axle-wagon"),
        ]
    )


@pytest.fixture(scope="module")
def all_rough(rough):
    return Train(
        vehicles=[vehicle.model_copy(update={"wheel_roughness": WHEELS}) for vehicle in rough.vehicles]
    )


def spectra(greby, track, train, approaches, **keys):
    keys = {"minimum_frequency": 12.5, "maximum_frequency": 25.0, **keys}
    return predict(greby, track, train, RAILS, 20.0, [8.0], approaches=approaches, **keys)


def test_parts_add_up(greby, track, rough):
    result = spectra(greby, track, rough, [*MOVING, "full"])
    for name in ("velocity_psd", "velocity_mean_square"):
        values = result[name]
        parts = values.sel(contribution="rails") + values.sel(contribution="wheels")
        np.testing.assert_allclose(values.sel(contribution="dynamic"), parts, rtol=1e-10)
        total = values.sel(contribution="dynamic") + values.sel(contribution="quasi-static")
        np.testing.assert_allclose(values.sel(contribution="total"), total, rtol=1e-10)


@pytest.mark.parametrize("averaging", ["line", "train"])
def test_rough_wheels_alone_are_never_correlated(greby, track, rough, averaging):
    """What the wheels give is the same in every form of moving roughness."""
    wheels = spectra(greby, track, rough, MOVING, averaging=averaging).sel(contribution="wheels")
    for approach in MOVING[1:]:
        np.testing.assert_array_equal(
            wheels.velocity_psd.sel(approach=approach), wheels.velocity_psd.sel(approach=MOVING[0])
        )


@pytest.mark.parametrize("averaging", ["line", "train"])
def test_equal_spectra_make_wheels_an_uncorrelated_rail(greby, track, all_rough, averaging):
    """Eq. 28, with the roughness of wheels in place of the unevenness under each axle alone."""
    result = spectra(greby, track, all_rough, ["moving-roughness-uncorrelated"], averaging=averaging)
    velocity = result.velocity_psd
    np.testing.assert_allclose(
        velocity.sel(contribution="wheels"), velocity.sel(contribution="rails"), rtol=1e-10
    )


def test_smooth_wheels_change_nothing(greby, track, rough):
    smooth = Train(
        vehicles=[vehicle.model_copy(update={"wheel_roughness": None}) for vehicle in rough.vehicles]
    )
    approaches = ["moving-roughness", "full"]
    result, with_wheels = (spectra(greby, track, train, approaches) for train in (smooth, rough))
    assert list(result.contribution.values) == ["dynamic", "quasi-static", "total"]
    np.testing.assert_array_equal(
        result.velocity_psd.sel(contribution="dynamic"), with_wheels.velocity_psd.sel(contribution="rails")
    )


def test_bands_of_both_approaches_meet_at_low_speed(greby, track, all_rough):
    """At 4 m/s the receiver hears the frequency that is excited: the full model's wheels are those of moving
    roughness within 0.5 dB per band.
    """
    result = predict(
        greby,
        track,
        all_rough,
        RAILS,
        4.0,
        [8.0],
        approaches=["moving-roughness", "full"],
        minimum_frequency=12.5,
        maximum_frequency=16.0,
    )
    wheels = result.velocity_mean_square.sel(contribution="wheels")
    difference = 10.0 * np.log10(wheels.sel(approach="full") / wheels.sel(approach="moving-roughness"))
    assert np.abs(difference).max() < 0.5


def test_wheels_of_different_make_add_up(greby, track, rough):
    """Two spectra at once are the sum of each alone; the full model resolves each on panels of its own."""
    orders = WheelRoughness(form="orders", order_level=(40.0, 30.0, 25.0, 22.0), circumference=2.6)
    leading, wagon = rough.vehicles
    second = wagon.model_copy(update={"wheel_roughness": orders})
    smooth = leading.model_copy(update={"wheel_roughness": None})
    both, first_alone, second_alone = (
        spectra(greby, track, Train(vehicles=vehicles), ["moving-roughness", "full"])
        .sel(contribution="wheels")
        .velocity_mean_square
        for vehicles in ([leading, second], [leading, wagon], [smooth, second])
    )
    for approach, tolerance in (("moving-roughness", 1e-10), ("full", 1e-4)):
        np.testing.assert_allclose(
            both.sel(approach=approach),
            first_alone.sel(approach=approach) + second_alone.sel(approach=approach),
            rtol=tolerance,
        )


def test_random_passages_hold_what_rough_wheels_add(greby, track, rough):
    """Over all bands to 0.1 dB: the record's lines end up to a step short of the outermost edges."""
    bands = {"minimum_frequency": 12.5, "maximum_frequency": 25.0, "rail": False}
    case = greby, track, rough, RAILS, 20.0, [8.0]
    spectrum = predict(*case, approaches=["full"], **bands).velocity_mean_square.sum("band")
    passage = predict_passage(*case, approaches=["full"], metrics=["ppv"], passages=16, **bands)
    energy = passage.variance.sum() * float(passage.time[1] - passage.time[0])
    mean_square = float(energy) * 20.0 / rough.length
    dynamic, wheels = (float(spectrum.sel(contribution=name).squeeze()) for name in ("dynamic", "wheels"))
    assert wheels > 0.3 * dynamic
    assert abs(10.0 * np.log10(mean_square / dynamic)) < 0.1
