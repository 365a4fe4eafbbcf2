"""The random passage in time: its energy is that of the spectra, and plain sums give the same."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from railvib.forces.receptance import tabulate_receptances
from railvib.numerics import third_octaves
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.passage.amplitudes import psd_over_passage, time_shift
from railvib.passage.ensemble import coefficients, sampled_lines
from railvib.passage.excitation import moving_excitation, standing_excitation
from railvib.passage.full_model import full_model_amplitudes
from railvib.passage.grid import passage_grid
from railvib.passage.levels import histories
from railvib.passage.moments import over_time, variance_spectra
from railvib.passage.moving_roughness import moving_roughness_amplitudes, moving_roughness_harmonics
from railvib.passage.quasi_static import quasi_static_amplitudes
from railvib.psd.excitation import excitation
from railvib.psd.full_model import passage_spectra
from railvib.psd.line_integrals import line_integrals
from railvib.psd.moving_roughness import axle_spans
from railvib.psd.moving_roughness_spectra import moving_roughness_spectra
from railvib.psd.quasi_static import quasi_static_spectra
from railvib.psd.spectra import Passage

SPEED = 150.0 / KMH
ROUGH = Unevenness(form="fra-hamid-yang", line_class=3)
RECEIVERS = (RAIL, *map(Receiver, (0.0, 8.0, 32.0)))
BLOCKS = range(-3, 5)
HIGHEST = 35.0
"""Highest frequency of excitation, Hz, three times the highest line."""
BAND = tuple(third_octaves.midbands(1.0, 10.0).tolist())
LINES_AT_ONCE = 100
CLOSE = 0.02
"""dB."""


@pytest.fixture(scope="module")
def soft():
    return Ground(
        layers=[Layer(shear_speed=120.0, dilatational_speed=300.0, density=1800.0, loss_factor=0.1)]
    )


@pytest.fixture(scope="module")
def functions(soft, track, tables):
    return tables(soft, track, BLOCKS, RECEIVERS, 1e-5)


@pytest.fixture(scope="module")
def passage(train):
    return Passage(train, ROUGH, SPEED, BAND)


@pytest.fixture(scope="module")
def moving(functions, track, train):
    return tabulate_receptances(functions[RAIL], track, SPEED, train.axle_distances, range(-3, 3))


@pytest.fixture(scope="module")
def standing(functions, track, train):
    return tabulate_receptances(functions[RAIL], track, 0.0, train.axle_distances, range(-3, 3))


def grid_of(soft, passage, refinement=1):
    return passage_grid(soft, passage.train.length, SPEED, BAND, HIGHEST, refinement)


@pytest.fixture(scope="module")
def grid(soft, passage):
    return grid_of(soft, passage)


def full_model(functions, train, moving, grid):
    q = moving_excitation(train, moving, ROUGH, SPEED, grid.wavenumber)
    return full_model_amplitudes(functions, q, train.axle_positions, train.length, SPEED, grid, LINES_AT_ONCE)


@pytest.fixture(scope="module")
def amplitudes(functions, train, moving, grid):
    return full_model(functions, train, moving, grid)


def mean_squares(frequency, psd, band):
    """Return the integrals over bands of spectra on even lines, by splines."""
    lower, upper = third_octaves.edges(band)
    spline = CubicSpline(frequency, psd, axis=-1)
    return np.stack([spline.integrate(*ends) for ends in zip(lower, upper, strict=True)], axis=-1)


@pytest.mark.parametrize("refinement", [1, 2])
def test_energy_of_the_full_model(functions, passage, moving, soft, train, refinement):
    """In bands to 0.02 dB for every receiver, also with twice the period."""
    grid = grid_of(soft, passage, refinement)
    of_passage = full_model(functions, train, moving, grid)
    excited = excitation(train, moving, ROUGH, SPEED, HIGHEST)
    spectra = passage_spectra(functions, excited, train.length, SPEED, passage.frequency)
    for receiver, psd in spectra.items():
        velocity = psd * (2.0 * np.pi * passage.frequency) ** 2
        in_time = psd_over_passage(of_passage[receiver], grid, train.length / SPEED)
        ratio = mean_squares(grid.frequency, in_time, BAND[1:-1]) / passage.lines.mean_squares(velocity)[1:-1]
        difference = 10.0 * np.log10(ratio)
        assert np.abs(difference).max() < CLOSE, receiver


@pytest.mark.parametrize("uncorrelated", [False, True])
@pytest.mark.parametrize("refinement", [1, 2])
def test_energy_of_moving_roughness(functions, passage, standing, soft, train, uncorrelated, refinement):
    """In bands of the unevenness' own frequency, to 0.02 dB for every receiver."""
    grid = grid_of(soft, passage, refinement)
    spans = axle_spans(train.axle_positions)
    integrals = line_integrals(functions, spans, range(-1, 2), 1e-5)
    name = "moving-roughness-uncorrelated" if uncorrelated else "moving-roughness"
    silent = dict.fromkeys(functions, np.zeros(passage.frequency.size))
    spectra = moving_roughness_spectra(name, passage, standing, silent, integrals, {})
    rows = (spectra.quantity == "velocity") & (spectra.contribution == "dynamic")
    own = grid.wavenumber * SPEED / (2.0 * np.pi)
    q = standing_excitation(train, standing, ROUGH, SPEED, grid.wavenumber, uncorrelated)
    position = train.axle_positions - 0.5 * train.length
    for receiver, mean_square in zip(functions, spectra.mean_square[rows], strict=True):
        in_time = np.zeros(own.size)
        for harmonics in moving_roughness_harmonics(functions[receiver], q, position, SPEED, grid):
            of_rows = slice(harmonics.row, harmonics.row + harmonics.value.shape[0])
            energy = np.einsum("nj,nj->n", harmonics.value, harmonics.value.conj()).real
            in_time[of_rows] += energy * harmonics.division
        in_time *= SPEED / (grid.step * train.length)
        # Harmonics lie half-way between whole values of s: their sum is the integral between these.
        up_to = CubicSpline(np.arange(own.size + 1), np.append(0.0, np.cumsum(in_time)))
        lower, upper = third_octaves.edges(BAND[1:-1])
        per_hz = 2.0 * np.pi / SPEED
        in_bands = up_to(grid.place(upper * per_hz)) - up_to(grid.place(lower * per_hz))
        difference = 10.0 * np.log10(in_bands / mean_square[1:-1])
        assert np.abs(difference).max() < CLOSE, receiver


def test_plain_sum(functions, train, moving, grid, amplitudes):
    """The judge: H̃ read point by point, axles and lines summed one by one, to 0.3 % of every line.

    Outermost harmonics with 1e-6 of a line's energy, 0.1 % of its amplitude, are left out.
    """
    receiver = Receiver(8.0)
    q = moving_excitation(train, moving, ROUGH, SPEED, grid.wavenumber)
    position = train.axle_positions + time_shift(grid, train.length, SPEED)
    random = coefficients(3, 0, 2, grid.wavenumber.size)
    lines = sampled_lines(amplitudes[receiver], grid, 3, 0, 2)
    chosen = range(5, grid.frequency.size, 97)
    for line in chosen:
        f = grid.frequency[line]
        total = np.zeros(2, complex)
        for sign in (1.0, -1.0):
            beta = sign * grid.wavenumber
            kappa = beta - 2.0 * np.pi * f / SPEED
            transfer = functions[receiver].along(np.full(kappa.size, f), kappa)
            of_axles = q if sign > 0.0 else q.conj()
            sum_of_axles = of_axles[0] @ np.exp(2j * np.pi * f * position / SPEED)
            u = grid.step / SPEED * transfer * sum_of_axles * 2j * np.pi * f * np.sqrt(grid.width)
            total += (random if sign > 0.0 else random.conj()) @ u
        np.testing.assert_allclose(lines[:, line], total, rtol=0.0, atol=3e-3 * np.abs(total).max())


def test_variance_of_histories(grid, amplitudes):
    """Σ_n |U_n(t)|² of the moments against the plain sum of squares over time, to 1e-5 of the largest."""
    blocks = [block for block in amplitudes[Receiver(32.0)] if not block.conjugate]
    samples = 2 * (grid.frequency.size + round(grid.frequency[0] / grid.step)) + 2
    first = round(grid.frequency[0] / grid.step)
    plain = np.zeros(samples)
    matrix = np.zeros((grid.wavenumber.size, grid.frequency.size), complex)
    for block in blocks:
        matrix[block.rows, block.lines] += block.value
    spectrum = np.zeros(samples, complex)
    for row in matrix[np.abs(matrix).max(axis=1) > 0.0]:
        spectrum[first : first + row.size] = row
        plain += np.abs(np.fft.ifft(spectrum) * samples) ** 2
    spectra = variance_spectra(blocks, grid, [np.ones(grid.frequency.size, complex)], grid.frequency.size)
    np.testing.assert_allclose(over_time(spectra, samples)[0], plain, atol=1e-5 * plain.max())


def test_mean_periodogram(grid, amplitudes, train):
    """Of 2,048 sampled passages, in bands: within five standard errors, and these below 0.2 dB."""
    receiver = Receiver(8.0)
    lines = np.concatenate([sampled_lines(amplitudes[receiver], grid, 1, batch, 256) for batch in range(8)])
    duration = train.length / SPEED
    periodogram = 0.5 * np.abs(lines) ** 2 / (grid.step**2 * duration)
    band = BAND[1:-1]
    sampled = mean_squares(grid.frequency, periodogram.astype(float), band)
    exact = mean_squares(grid.frequency, psd_over_passage(amplitudes[receiver], grid, duration), band)
    error = sampled.std(axis=0, ddof=1) / np.sqrt(len(lines))
    assert np.all(error < 0.05 * exact)
    assert np.all(np.abs(sampled.mean(axis=0) - exact) < 5.0 * error)


def test_quasi_static_history(soft, track, functions, train, grid):
    """Its energy on every line is that of the quasi-static spectrum, to 1e-6."""
    frequency = grid.frequency
    position = train.axle_positions + time_shift(grid, train.length, SPEED)
    axles = train.axle_positions, train.axle_loads
    psd = quasi_static_spectra(soft, track, functions, *axles, train.length, SPEED, frequency)
    for receiver, function in functions.items():
        mean = quasi_static_amplitudes(function, train.axle_loads, position, SPEED, grid)
        expected = psd[receiver] * (2.0 * np.pi * frequency) ** 2
        in_time = 0.5 * np.abs(mean) ** 2 / (grid.step**2 * train.length / SPEED)
        np.testing.assert_allclose(in_time, expected, rtol=1e-6, atol=1e-12 * expected.max())


def test_quasi_static_history_is_symmetric(functions, train, grid):
    """At its own place in the record: the axles of this train lie alike from both ends.

    Damping delays the response, so that only the share of the energy before and after is compared: half, to
    2 %.
    """
    position = train.axle_positions + time_shift(grid, train.length, SPEED)
    mean = quasi_static_amplitudes(functions[RAIL], train.axle_loads, position, SPEED, grid)
    history = histories(mean, grid, 4096)
    first = np.sum(history[:2048] ** 2) / np.sum(history**2)
    assert abs(first - 0.5) < 0.02
    inside = np.abs(np.arange(4096) - 2048) / 4096 / grid.step < 0.6 * train.length / SPEED
    assert np.sum(history[inside] ** 2) > 0.98 * np.sum(history**2)


def test_slow_train(functions, soft, track, train):
    """At 5 m/s the full model and moving roughness agree in bands to 0.2 dB, and over all to 0.02 dB.

    What is left is Doppler's shift by 4 %, which moves energy across the edges of bands. At 150 km/h bands
    differ by several decibels.
    """
    speed = 5.0
    receiver = Receiver(8.0)
    band = tuple(third_octaves.midbands(2.0, 10.0).tolist())
    grid = passage_grid(soft, train.length, speed, band, 30.0)
    chosen = {receiver: functions[receiver]}
    receptances = [
        tabulate_receptances(functions[RAIL], track, each, train.axle_distances, range(-3, 3))
        for each in (speed, 0.0)
    ]
    q = moving_excitation(train, receptances[0], ROUGH, speed, grid.wavenumber)
    full = full_model_amplitudes(chosen, q, train.axle_positions, train.length, speed, grid, LINES_AT_ONCE)[
        receiver
    ]
    standing = standing_excitation(train, receptances[1], ROUGH, speed, grid.wavenumber)
    position = train.axle_positions - 0.5 * train.length
    still = list(moving_roughness_amplitudes(chosen[receiver], standing, position, speed, grid))
    duration = train.length / speed
    both = [
        mean_squares(grid.frequency, psd_over_passage(each, grid, duration), band[1:-1])
        for each in (full, still)
    ]
    assert np.abs(10.0 * np.log10(both[0] / both[1])).max() < 0.2
    assert abs(10.0 * np.log10(both[0].sum() / both[1].sum())) < 0.02
