"""Where the contact of track and ground is not passive, against the receptances of the tables."""

import warnings

import numpy as np
import pytest

from railvib import library, predict, rail_receptance
from railvib.errors import PlausibilityWarning
from railvib.parameters.ground import Ground, Layer
from railvib.transfer.passivity import nonpassive_ranges
from tests.physics.judges import random_ground

SATURATED = Ground(
    layers=[Layer(shear_speed=80.0, dilatational_speed=1500.0, density=1700.0, loss_factor=0.05)]
)


def receptance(track, ground, frequency):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PlausibilityWarning)
        return rail_receptance(track, ground, frequency)


def test_soft_saturated_ground(track):
    ((low, high),) = nonpassive_ranges(SATURATED, track, 1.0, 112.0)
    assert low == pytest.approx(82.6, abs=0.2)
    assert high == pytest.approx(95.8, abs=0.3)


def test_soils_of_the_paper(track, greby, horstwalde):
    assert nonpassive_ranges(greby, track, 1.0, 360.0) == []
    ((low, high),) = nonpassive_ranges(horstwalde, track, 1.0, 360.0)
    assert low == pytest.approx(248.2, abs=0.5)
    assert high == pytest.approx(309.2, abs=0.5)
    assert nonpassive_ranges(horstwalde, track, 1.0, 240.0) == []
    assert nonpassive_ranges(horstwalde, track, 260.0, 270.0) == [(260.0, 270.0)]
    assert nonpassive_ranges(horstwalde, track, 320.0, 330.0) == []


def test_narrow_contact_is_passive(track):
    narrow = track.model_copy(update={"contact_width": 0.8})
    assert nonpassive_ranges(SATURATED, narrow, 1.0, 112.0) == []


@pytest.mark.parametrize("seed", range(8))
def test_sign_of_the_receptance(seed, track):
    rng = np.random.default_rng([41, seed])
    ground = random_ground(rng)
    ranges = nonpassive_ranges(ground, track, 1.0, 120.0)
    for frequency in rng.uniform(20.0, 120.0, 4):
        edges = np.array(ranges).ravel()
        if np.abs(edges / frequency - 1.0).min(initial=1.0) > 0.01:
            inside = any(low < frequency < high for low, high in ranges)
            assert (receptance(track, ground, frequency).imag > 0.0) == inside


def test_warning_of_receptances(track):
    with pytest.warns(
        PlausibilityWarning, match=r"not passive at 83 to 96 Hz .* narrower contact_width_m or"
    ):
        rail_receptance(track, SATURATED, [60.0, 100.0])
    rail_receptance(track, SATURATED, [10.0, 80.0])


def test_warning_of_predictions(track, train):
    with pytest.warns(PlausibilityWarning, match="not passive at 83 to 89 Hz"):
        predict(
            SATURATED,
            track,
            train,
            library.load("unevenness", "fra-hamid-yang-3"),
            15.0,
            approaches=["moving-roughness"],
            minimum_frequency=80.0,
            maximum_frequency=80.0,
        )
