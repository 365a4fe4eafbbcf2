"""Laws of the coupling at the centre line and of that with the mean over the contact width."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from railvib import library
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground, Layer
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.strip import mean_fit_reach, strip_compliance, strip_mean
from railvib.transfer.compliance_under_track import compliance_under_track
from railvib.transfer.track_response import track_response
from tests.physics.judges import random_ground

STUDY = Path(__file__).parents[2] / "studies" / "coupling.py"


def assert_takes_energy(ground, track, frequencies):
    """Im of the mean compliance and of the rail's response are negative at every wavenumber."""
    start = None
    for frequency in frequencies:
        fit = fit_flexibility(ground, float(frequency), 1e-9, start, mean_fit_reach(track.half_width))
        start = fit.start
        assert fit.error < 1e-6
        omega = 2.0 * np.pi * frequency
        waves = np.linspace(0.0, 2.0, 60) * omega / ground.slowest_speed
        beta = np.concatenate([waves, np.geomspace(waves[-1], 100.0 + waves[-1], 20)])
        compliance = compliance_under_track(fit, beta, track)
        assert np.all(compliance.imag < 0.0)
        rail, _force = track_response(track, beta, omega, compliance)
        assert np.all(rail.imag < 0.0)


@pytest.fixture(scope="module")
def following(track):
    """The paper's track, following the ground's mean."""
    return track.model_copy(update={"coupling": "mean"})


@pytest.mark.parametrize("seed", range(4))
def test_mean_is_passive(seed, following):
    ground = random_ground(np.random.default_rng([16, seed]))
    assert_takes_energy(ground, following, np.geomspace(0.5, 500.0, 12))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(200))
def test_mean_is_passive_on_many_grounds(seed, following):
    ground = random_ground(np.random.default_rng([17, seed]))
    assert_takes_energy(ground, following, np.geomspace(0.5, 500.0, 31))


def test_mean_is_passive_where_the_centre_is_not(track, following):
    saturated = Ground(
        layers=[Layer(shear_speed=80.0, dilatational_speed=1500.0, density=1700.0, loss_factor=0.05)]
    )
    fit = fit_flexibility(saturated, 90.0, 1e-9, largest=mean_fit_reach(track.half_width))
    beta = np.linspace(0.0, 2.0, 200) * 2.0 * np.pi * 90.0 / 80.0
    assert compliance_under_track(fit, beta, track).imag.max() > 0.0
    assert_takes_energy(saturated, following, [85.0, 90.0, 95.0, 500.0])


@pytest.mark.parametrize("soil", ["greby", "horstwalde"])
def test_couplings_meet_under_narrow_tracks(soil):
    """Under a narrow strip the ground dishes as at rest, by (1−ν)/(πμ)·(ln 2 − 1/2) per load between centre
    and mean; what remains of the difference falls with the square of the width over the wavelength, and the
    dish itself is ever less of the whole.
    """
    ground = library.load("soil", soil)
    top = ground.layers[0]
    modulus = top.density * top.shear_speed**2 * (1.0 + 1j * top.loss_factor)
    ratio = (top.dilatational_speed / top.shear_speed) ** 2
    poisson = (ratio - 2.0) / (2.0 * ratio - 2.0)
    dish = (1.0 - poisson) / (np.pi * modulus) * (np.log(2.0) - 0.5)
    frequency, beta = 20.0, np.array([0.0, 0.3, 0.8])
    left, share = [], []
    for half_width in (0.1, 0.05, 0.025):
        fit = fit_flexibility(ground, frequency, 1e-12, largest=30.0 * mean_fit_reach(half_width))
        centre = strip_compliance(fit, beta, half_width, np.array([0.0]))[0]
        difference = centre - strip_mean(fit, beta, half_width)
        left.append(np.abs(difference - dish) / np.abs(dish))
        share.append(np.abs(difference / centre))
    phase = 2.0 * np.pi * frequency / ground.slowest_speed * 0.1
    assert left[0].max() < phase**2 * (1.0 - np.log(phase))
    for wide, narrow in zip(left[:-1], left[1:], strict=True):
        np.testing.assert_array_less(narrow, 0.33 * wide)  # 1/4, and a logarithm that varies slowly
    assert np.all(np.diff(share, axis=0) < 0.0)


def test_mean_is_one_smooth_element_of_the_verification_model(following, greby, horstwalde):
    """A Galerkin element under uniform pressure takes the mean: another closed form of the same number."""
    from railvib.fe_be.model import fe_be_response

    section = CrossSection(bed="columns", contact="smooth", elements=1)
    beta = np.array([0.0, 0.01, 0.1, 0.5, 1.0, 3.0, 10.0, 19.0])
    for ground in (greby, horstwalde):
        for frequency in (2.0, 20.0, 80.0):
            fit = fit_flexibility(ground, frequency, 1e-10, largest=mean_fit_reach(following.half_width))
            rail, _force = track_response(
                following, beta, 2.0 * np.pi * frequency, compliance_under_track(fit, beta, following)
            )
            response = fe_be_response(ground, following, section, frequency, beta)
            np.testing.assert_allclose(response.rail, rail, rtol=1e-6)


@pytest.mark.parametrize(("soil", "frequency"), [("horstwalde", 10.0), ("horstwalde", 80.0), ("greby", 16.0)])
def test_verification_model_is_nearer_to_the_mean(soil, frequency):
    """Of the rail, at the frequencies of the table in docs/theory/track-and-forces.md where they differ."""
    mean, verification = runpy.run_path(str(STUDY))["differences"](soil, frequency)[:, 0]
    assert abs(mean) > 0.3
    assert abs(verification - mean) < abs(verification)
