"""Weightings against printed factors, an implementation by zeros and poles, and a filter bank in time."""

import numpy as np
import pytest
from pyoctaveband import OctaveFilterBank

from railvib.levels import weightings
from railvib.levels.weightings import WEIGHTINGS, weighted
from railvib.numerics import third_octaves
from tests.data.levels import golden

ROWS = golden.rows("weightings")
FREQUENCY = np.array([float(row["frequency_hz"]) for row in ROWS])


def column(name):
    return np.array([float(row[name]) for row in ROWS])


@pytest.mark.parametrize("name", ["Wb", "Wd", "Wk", "Wm"])
def test_printed_factors_of_iso_8041_1(name):
    """Four printed digits; 1e-3 is a fiftieth of the tolerance of a meter."""
    factor = np.abs(WEIGHTINGS[name.lower()].response(FREQUENCY))
    np.testing.assert_allclose(factor, column(f"{name}_iso8041_1_annex_b"), rtol=1e-3)


@pytest.mark.parametrize("name", ["Wb", "Wd", "Wk", "Wm"])
def test_magnitude_and_phase_by_zeros_and_poles(name):
    response = WEIGHTINGS[name.lower()].response(FREQUENCY)
    np.testing.assert_allclose(np.abs(response), column(name), rtol=2e-9)
    difference = np.angle(response, deg=True) - column(f"{name}_phase_deg")
    np.testing.assert_allclose((difference + 180.0) % 360.0 - 180.0, 0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "golden_name"),
    [
        ("kb", "KB_1_80"),
        ("kb-4-315", "KB_4_315"),
        ("sbr-b", "KB_bare"),
        ("wm-velocity", "Wm_velocity"),
    ],
)
def test_weightings_of_velocity(name, golden_name):
    np.testing.assert_allclose(np.abs(WEIGHTINGS[name].response(FREQUENCY)), column(golden_name), rtol=2e-9)


def test_weighted_velocity_is_wm_of_acceleration_over_its_time():
    """ISO 2631-2: a_w = v_w/0.028 s."""
    acceleration = WEIGHTINGS["wm"].of_velocity(FREQUENCY)
    velocity = WEIGHTINGS["wm-velocity"].of_velocity(FREQUENCY)
    np.testing.assert_allclose(acceleration * weightings.WM_TIME, velocity, rtol=1e-12)


@pytest.mark.parametrize(("name", "corners"), [("band-1-80", (0.8, 100.0)), ("band-4-315", (3.2, 393.75))])
def test_band_limits_are_3_db_down_at_their_corners(name, corners):
    lower, upper = np.abs(WEIGHTINGS[name].response(np.array(corners)))
    assert lower == pytest.approx(np.sqrt(0.5), rel=1e-7)
    assert upper == pytest.approx(np.sqrt(0.5), rel=1e-7)


def test_no_weighting_passes_a_constant():
    for weighting in WEIGHTINGS.values():
        assert weighting.of_velocity([0.0]) == 0.0


@pytest.mark.parametrize("midband", third_octaves.midbands(1.0, 100.0)[::4])
def test_third_octave(midband):
    lower, upper = third_octaves.edges(midband)
    at = np.array([lower, midband, upper])
    np.testing.assert_allclose(np.abs(weightings.third_octave(midband)(at)) ** 2, [0.5, 1.0, 0.5], rtol=1e-12)


def test_third_octaves_against_a_bank_in_time():
    """PyOctaveBand's filters of order 3 are bilinear: at 400 times the midband they are the prototype."""
    rate = 4000
    rng = np.random.default_rng(1)
    signal = rng.normal(size=3 * rate)
    bank = OctaveFilterBank(rate, 3, 3, [4, 10], resample=False)
    _, _, bands = bank.filter(signal, sigbands=True, detrend=False, calculate_level=False)
    assert len(bands) == 5
    for midband, expected in zip(bank.freq, bands, strict=True):
        band = weighted(signal, 1.0 / rate, weightings.third_octave(midband), 6.0)
        np.testing.assert_allclose(band, expected, atol=1e-3 * np.abs(expected).max())


def test_a_filter_starts_at_rest_and_does_not_wrap():
    """A longer record of the same signal leaves its first part as it was."""
    rng = np.random.default_rng(2)
    step = 1e-3
    smooth = np.hanning(20)  # little near half the sampling rate, where no filter is that of continuous time
    signal = np.convolve(rng.normal(size=3981), smooth)
    kb = WEIGHTINGS["kb"]
    short = weighted(signal, step, kb.response, kb.rest)
    long = weighted(np.append(signal, np.zeros(20_000)), step, kb.response, kb.rest)
    np.testing.assert_allclose(short, long[:4000], atol=1e-9 * np.abs(short).max())


def test_weighted_rms_of_a_spectrum_is_that_of_its_signal():
    rng = np.random.default_rng(3)
    count, step = 4096, 1.0 / 512.0
    frequency = np.fft.rfftfreq(count, step)
    amplitude = rng.normal(size=frequency.size) + 1j * rng.normal(size=frequency.size)
    amplitude[(frequency < 2.0) | (frequency > 100.0)] = 0.0
    wk = WEIGHTINGS["wk"]
    signal = np.fft.irfft(amplitude * wk.of_velocity(frequency), count)
    psd = np.abs(amplitude) ** 2 * 2.0 / count**2 * (count * step)
    expected = np.sqrt(np.mean(signal**2))
    assert weightings.weighted_rms(frequency, psd, wk.of_velocity) == pytest.approx(expected, rel=1e-12)
