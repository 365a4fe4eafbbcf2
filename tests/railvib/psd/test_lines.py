"""Narrow-band lines of a case: which there are, and integrals of rippled and steep spectra over bands."""

import numpy as np
import pytest

from railvib.errors import InputError
from railvib.numerics import third_octaves
from railvib.parameters.units import KMH
from railvib.parameters.vehicle import Train
from railvib.psd.lines import Lines, lines

TRAIN_LENGTH, SPEED = 106.4, 150 / KMH
AXLES = np.add.outer(13.3 + 26.6 * np.arange(4), np.add.outer([-9.5, 9.5], [-1.35, 1.35])).ravel()
BANDS = tuple(third_octaves.midbands(1.0, 100.0).tolist())


def even(bands, step):
    """Return lines over bands at most a step apart."""
    lower, upper = third_octaves.edges(bands)
    return Lines(tuple(bands), tuple(np.maximum(np.ceil((upper - lower) / step), 24).astype(int).tolist()))


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


@pytest.mark.parametrize(("division", "tolerance_db"), [(8, 2e-3), (16, 1e-5)])
@pytest.mark.parametrize("slope", [0.0, 2.0, -4.0])
def test_comb_of_a_train(slope, division, tolerance_db):
    on_lines = even(BANDS, SPEED / (division * TRAIN_LENGTH))
    mean_square = on_lines.mean_squares(comb(on_lines.frequency, slope))
    edges = zip(*third_octaves.edges(BANDS), strict=True)
    expected = [integral(lambda f: comb(f, slope), lower, upper) for lower, upper in edges]
    np.testing.assert_allclose(10 * np.log10(mean_square / expected), 0.0, atol=tolerance_db)


def test_polynomials_are_exact():
    bands = third_octaves.midbands(4.0, 8.0)
    on_lines = Lines(tuple(bands), (8, 12, 9, 23))
    lower, upper = third_octaves.edges(bands)
    mean_square = on_lines.mean_squares(on_lines.frequency**7)
    np.testing.assert_allclose(mean_square, (upper**8 - lower**8) / 8, rtol=1e-12)


@pytest.mark.parametrize(("decay", "count", "tolerance"), [(0.7, 21, 1e-9), (12.0, 6, 1e-6), (48.0, 2, 1e-5)])
def test_steep_spectra_keep_their_small_bands(decay, count, tolerance):
    """A decay of 48 per Hz is 14 nepers, 60 dB, over the band of 1.25 Hz."""
    on_lines = even(BANDS[:count], 0.02)
    lower, upper = third_octaves.edges(on_lines.band)
    mean_square = on_lines.mean_squares(np.exp(-decay * on_lines.frequency))
    expected = (np.exp(-decay * lower) - np.exp(-decay * upper)) / decay
    np.testing.assert_allclose(mean_square, expected, rtol=tolerance)


def test_a_steep_comb():
    """As of a load that moves past far away."""
    bands = BANDS[:4]
    on_lines = even(bands, SPEED / (8 * TRAIN_LENGTH))

    def steep(frequency):
        return comb(frequency) * np.exp(-30.0 * frequency)

    edges = zip(*third_octaves.edges(bands), strict=True)
    expected = [integral(steep, lower, upper) for lower, upper in edges]
    np.testing.assert_allclose(on_lines.mean_squares(steep(on_lines.frequency)), expected, rtol=1e-3)


def test_a_single_line_stays_in_its_band():
    on_lines = even(BANDS, 0.05)
    psd = np.full(on_lines.frequency.size, 1e-12)
    psd[np.abs(on_lines.frequency - 10.0).argmin()] = 1.0
    mean_square = on_lines.mean_squares(psd)
    lower, upper = third_octaves.edges(BANDS)
    other = np.arange(len(BANDS)) != 10
    np.testing.assert_allclose(mean_square[other], 1e-12 * (upper - lower)[other], rtol=1e-9)
    assert mean_square[10] == pytest.approx(0.05, rel=0.2)


def test_mean_squares_are_never_negative():
    random = np.random.default_rng(7)
    on_lines = even(BANDS, 0.2)
    psd = 10.0 ** random.uniform(-12.0, 0.0, (200, on_lines.frequency.size))
    assert np.all(on_lines.mean_squares(psd) > 0.0)


def test_leading_axes_and_sums():
    on_lines = even(third_octaves.midbands(2.0, 50.0), 0.03)
    frequency = on_lines.frequency
    psd = np.stack([comb(frequency), comb(frequency, -2.0), np.ones_like(frequency)]).reshape(3, 1, -1)
    mean_square = on_lines.mean_squares(psd)
    assert mean_square.shape == (3, 1, len(on_lines.band))
    np.testing.assert_allclose(mean_square[1, 0], on_lines.mean_squares(psd[1, 0]), rtol=1e-13)
    lower, upper = third_octaves.edges(on_lines.band)
    np.testing.assert_allclose(mean_square[2, 0], upper - lower, rtol=1e-12)


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_refused_densities(value):
    on_lines = even((10.0,), 0.1)
    psd = np.ones_like(on_lines.frequency)
    psd[5] = value
    with pytest.raises(InputError, match="psd"):
        on_lines.mean_squares(psd)
    with pytest.raises(InputError, match="last axis"):
        on_lines.mean_squares(psd[1:])


def test_lines_of_a_band_do_not_depend_on_the_others(train):
    every = lines(BANDS, train, SPEED)
    for first, last in ((0, 1), (3, 8), (20, 21)):
        some = lines(BANDS[first:last], train, SPEED)
        assert some.intervals == every.intervals[first:last]
        start = sum(every.intervals[:first])
        shared = every.frequency[start : start + some.frequency.size]
        np.testing.assert_allclose(some.frequency, shared, rtol=1e-14)


def test_edges_of_bands_are_lines(train):
    on_lines = lines(BANDS, train, SPEED)
    lower, upper = third_octaves.edges(BANDS)
    places = np.concatenate([[0], np.cumsum(on_lines.intervals)])
    np.testing.assert_allclose(on_lines.frequency[places], [*lower, upper[-1]], rtol=1e-14)


def test_ripple_and_resonances_are_resolved(vehicle):
    """The number of intervals grows with the train, with a sharper resonance, and doubles where asked."""
    single, long = Train(vehicles=[vehicle]), Train(vehicles=[vehicle] * 8)
    sharp = vehicle.model_copy(update={"secondary_damping": 0.0})
    usual = lines(BANDS, single, 80.0)
    assert all(n <= m for n, m in zip(usual.intervals, lines(BANDS, long, 80.0).intervals, strict=True))
    sharper = lines(BANDS, Train(vehicles=[sharp]), 80.0)
    assert sharper.intervals[0] > usual.intervals[0]  # the car bounces and pitches at 0.8 and 1.1 Hz
    assert sharper.intervals[15:] == usual.intervals[15:]
    assert lines(BANDS, single, 80.0, 2).intervals == tuple(2 * n for n in usual.intervals)
