"""One-third octaves: the series, exact integrals of rippled and steep spectra, levels."""

import numpy as np
import pytest

from railvib.errors import InputError
from railvib.numerics import third_octaves
from railvib.parameters.units import KMH

TRAIN_LENGTH, SPEED = 106.4, 150 / KMH
AXLES = np.add.outer(13.3 + 26.6 * np.arange(4), np.add.outer([-9.5, 9.5], [-1.35, 1.35])).ravel()


def comb(frequency, slope=0.0):
    """Return the spectrum of sixteen unequal coherent axles passing a point, times a power of frequency."""
    amplitude = 1.0 + 0.02 * np.arange(16)
    phase = np.exp(2j * np.pi * np.multiply.outer(frequency, AXLES) / SPEED)
    return np.abs(phase @ amplitude) ** 2 * frequency**slope


def integral(function, lower, upper):
    """Integrate by dense Gauss panels."""
    points, weights = np.polynomial.legendre.leggauss(24)
    ends = np.linspace(lower, upper, int((upper - lower) / 0.1) + 4)
    half = 0.5 * np.diff(ends)[:, np.newaxis]
    return float(np.sum(half * weights * function(ends[:-1, np.newaxis] + half * (1 + points))))


def grid(step, midbands):
    lower, upper = third_octaves.edges(midbands)
    return step * np.arange(np.floor(lower.min() / step) - 4, np.ceil(upper.max() / step) + 5)


def test_series():
    midbands = third_octaves.midbands(1.0, 100.0)
    np.testing.assert_allclose(midbands, 10 ** (np.arange(21) / 10))
    labels = [third_octaves.nominal_label(f) for f in midbands]
    assert labels == "1 1.25 1.6 2 2.5 3.15 4 5 6.3 8 10 12.5 16 20 25 31.5 40 50 63 80 100".split()
    assert [third_octaves.nominal_label(10 ** (n / 10)) for n in (-5, 27, 30)] == ["0.315", "500", "1000"]


@pytest.mark.parametrize(
    ("limits", "count"), [((1.6, 31.5), 14), ((1.25, 1.25), 1), ((10**0.2, 10**1.5), 14)]
)
def test_limits_may_be_nominal_or_exact(limits, count):
    assert third_octaves.midbands(*limits).size == count


@pytest.mark.parametrize(
    "limits", [(0.0, 10.0), (10.0, 1.0), (1.0, float("inf")), (float("nan"), 1.0), (1.1, 1.15)]
)
def test_refused_limits(limits):
    with pytest.raises(InputError, match="bands from"):
        third_octaves.midbands(*limits)


def test_bands_share_their_edges():
    lower, upper = third_octaves.edges(third_octaves.midbands(0.1, 1000.0))
    np.testing.assert_allclose(upper[:-1], lower[1:], rtol=1e-14)


@pytest.mark.parametrize(("division", "tolerance_db"), [(8, 2e-3), (16, 1e-5)])
@pytest.mark.parametrize("slope", [0.0, 2.0, -4.0])
def test_comb_of_a_train(slope, division, tolerance_db):
    midbands = third_octaves.midbands(1.0, 100.0)
    frequency = grid(SPEED / (division * TRAIN_LENGTH), midbands)
    found = third_octaves.band_mean_squares(frequency, comb(frequency, slope), midbands)
    expected = [
        integral(lambda f: comb(f, slope), *each) for each in zip(*third_octaves.edges(midbands), strict=True)
    ]
    np.testing.assert_allclose(10 * np.log10(found / expected), 0.0, atol=tolerance_db)


def test_polynomials_are_exact_on_any_grid():
    midbands = third_octaves.midbands(4.0, 8.0)
    frequency = np.linspace(
        third_octaves.edges(midbands)[0].min(), third_octaves.edges(midbands)[1].max(), 23
    )
    lower, upper = third_octaves.edges(midbands)
    found = third_octaves.band_mean_squares(frequency, frequency**7, midbands)
    np.testing.assert_allclose(found, (upper**8 - lower**8) / 8, rtol=1e-12)


def test_a_spectrum_over_thirty_decades_keeps_its_small_bands():
    midbands = third_octaves.midbands(1.0, 100.0)
    frequency = grid(0.02, midbands)
    lower, upper = third_octaves.edges(midbands)
    decay = 0.7  # per Hz: e^-70 at the end
    found = third_octaves.band_mean_squares(frequency, np.exp(-decay * frequency), midbands)
    np.testing.assert_allclose(found, (np.exp(-decay * lower) - np.exp(-decay * upper)) / decay, rtol=1e-9)


def test_a_single_line_stays_where_it_is():
    midbands = third_octaves.midbands(1.0, 100.0)
    frequency = grid(0.05, midbands)
    psd = np.full(frequency.size, 1e-12)
    psd[np.abs(frequency - 10.0).argmin()] = 1.0
    found = third_octaves.band_mean_squares(frequency, psd, midbands)
    lower, upper = third_octaves.edges(midbands)
    other = np.arange(midbands.size) != 10
    np.testing.assert_allclose(found[other], 1e-12 * (upper - lower)[other], rtol=1e-9)
    assert found[10] == pytest.approx(0.05, rel=0.2)


def test_mean_squares_are_never_negative():
    random = np.random.default_rng(7)
    midbands = third_octaves.midbands(1.0, 100.0)
    frequency = grid(0.2, midbands)
    psd = 10.0 ** random.uniform(-12.0, 0.0, (200, frequency.size))
    assert np.all(third_octaves.band_mean_squares(frequency, psd, midbands) > 0.0)


def test_leading_axes_and_sums():
    midbands = third_octaves.midbands(2.0, 50.0)
    frequency = grid(0.03, midbands)
    psd = np.stack([comb(frequency), comb(frequency, -2.0), np.ones_like(frequency)]).reshape(3, 1, -1)
    found = third_octaves.band_mean_squares(frequency, psd, midbands)
    assert found.shape == (3, 1, midbands.size)
    np.testing.assert_allclose(
        found[1, 0], third_octaves.band_mean_squares(frequency, psd[1, 0], midbands), rtol=1e-13
    )
    lower, upper = third_octaves.edges(midbands)
    np.testing.assert_allclose(found[2, 0], upper - lower, rtol=1e-12)


@pytest.mark.parametrize(
    ("frequency", "message"),
    [
        (np.linspace(0.95, 200.0, 2000), "must cover the bands' edges"),
        (np.linspace(0.1, 110.0, 2000), "must cover the bands' edges"),
        (np.geomspace(0.1, 200.0, 2000), "uniform"),
        (np.linspace(200.0, 0.1, 2000), "uniform"),
        (np.linspace(0.1, 200.0, 7), "at least 8 samples"),
    ],
)
def test_refused_grids(frequency, message):
    with pytest.raises(InputError, match=message):
        third_octaves.band_mean_squares(
            frequency, np.ones_like(frequency), third_octaves.midbands(1.0, 100.0)
        )


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_refused_densities(value):
    frequency = np.linspace(0.1, 200.0, 2000)
    psd = np.ones_like(frequency)
    psd[500] = value
    with pytest.raises(InputError, match="psd"):
        third_octaves.band_mean_squares(frequency, psd, [10.0])
    with pytest.raises(InputError, match="last axis"):
        third_octaves.band_mean_squares(frequency, psd[1:], [10.0])
