"""Where the contact of track and ground is not passive, against the receptances of the tables."""

import warnings

import numpy as np
import pytest

from railvib import library, predict, rail_receptance
from railvib.errors import PlausibilityWarning
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL
from railvib.parameters.track import Track
from railvib.plausibility import check_contact
from railvib.psd.line_integrals import line_integrals
from railvib.soil.quadrature import adaptive_integral
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.strip import strip_compliance
from railvib.transfer.passivity import nonpassive_ranges
from railvib.transfer.track_response import track_response
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


def test_mean_is_passive_everywhere(track):
    following = Track(**{**track.model_dump(), "coupling": "mean"})
    assert nonpassive_ranges(SATURATED, following, 1.0, 400.0) == []
    for frequency in (82.0, 90.0, 200.0, 350.0):
        assert receptance(following, SATURATED, frequency).imag < 0.0


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


def direct_line_integral(track, ground, frequency):
    """(1/π) ∫ |H̃_R|² dβ by adaptive quadrature of a fit at that frequency alone."""
    omega = 2.0 * np.pi * frequency
    fit = fit_flexibility(ground, frequency, 1e-10)

    def squared(beta):
        compliance = strip_compliance(fit, beta, track.half_width, np.array([0.0]))[0]
        return np.abs(track_response(track, beta, omega, compliance)[0])[:, None] ** 2 / np.pi

    peak = np.linspace(1.6, 2.1, 200)
    edges = np.unique(np.concatenate([np.linspace(0.0, 20.0, 60), peak, np.linspace(20.0, 100.0, 20)]))
    return float(adaptive_integral(squared, edges, 1e-7)[0])


def test_line_integrals_around_the_range(track, horstwalde, tables):
    """Tables resolve the rail's response inside and above the range, but for a few hertz at its end, where
    the integral has no bound; these are warned of.
    """
    function = tables(horstwalde, track, range(4, 5), (RAIL,))
    frequency = np.array([200.0, 240.0, 260.0, 280.0, 300.0, 315.0, 340.0])
    integral = line_integrals(function, [0.0], range(4, 5))[RAIL].at(frequency)[:, 0]
    expected = [direct_line_integral(track, horstwalde, float(f)) for f in frequency]
    np.testing.assert_allclose(integral, expected, rtol=1e-4)
    with pytest.warns(PlausibilityWarning, match="not passive at 303 to 309 Hz"):
        check_contact(horstwalde, track, 312.0, 355.0)
    check_contact(horstwalde, track, 320.0, 355.0)


def test_integral_has_no_bound_at_the_end_of_the_range(track, horstwalde):
    ((_low, end),) = nonpassive_ranges(horstwalde, track, 1.0, 360.0)
    away = [direct_line_integral(track, horstwalde, end + step) for step in (-10.0, -0.5, 0.5, 10.0)]
    assert away[1] > 10.0 * away[0]
    assert away[2] > 10.0 * away[3]


def test_warning_of_receptances(track):
    with pytest.warns(
        PlausibilityWarning,
        match=r'not passive at 83 to 96 Hz .*; coupling = "mean" on the track, a narrower contact_width_m or',
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
