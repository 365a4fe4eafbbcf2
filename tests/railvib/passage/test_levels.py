"""Levels of a synthetic passage: one receiver, amplitudes that are given."""

import numpy as np
import pytest

from railvib.levels.running import FAST
from railvib.parameters.metric import METRICS
from railvib.passage.amplitudes import Block
from railvib.passage.grid import Grid
from railvib.passage.levels import expectations, histories, sampled_values, statistics
from railvib.passage.metrics import signals

STEP = 0.05
BAND = 10.0 ** (np.arange(8, 16) / 10.0)
QUANTILES = (0.05, 0.5, 0.95)


@pytest.fixture(scope="module")
def grid():
    frequency = STEP * np.arange(100, 720)
    return Grid(frequency, STEP, 256.0, 64.0, 0.1, 3.0)


@pytest.fixture(scope="module")
def amplitudes(grid):
    """Noise from 5 to 36 Hz that comes and goes within three seconds in the middle of the record."""
    random = np.random.default_rng(5)
    count = grid.wavenumber.size
    time = np.arange(4096) / 4096 / STEP
    envelope = np.exp(-0.5 * ((time - 0.5 / STEP) / 1.5) ** 2)
    carrier = grid.frequency[random.integers(40, 580, count)]
    phase = random.uniform(0.0, 2.0 * np.pi, count)[:, None]
    signal = envelope * np.exp(1j * (2.0 * np.pi * carrier[:, None] * time + phase))
    first = round(grid.frequency[0] / STEP)
    value = np.fft.fft(signal, axis=1)[:, first : first + grid.frequency.size] / 4096 * 1e-4
    return [Block(0, 0, value.astype(np.complex64), False, 0)]


def levels(amplitudes, mean, grid, passages, seed=1, metrics=METRICS):
    wanted = list(signals(metrics, grid.frequency, BAND))
    values = sampled_values(amplitudes, mean, grid, wanted, passages, seed)
    expected = expectations(amplitudes, mean, grid, wanted)
    rows = statistics(values, expected, QUANTILES)
    return {(row.metric, row.statistic): row.value for row in rows}


@pytest.fixture(scope="module")
def silent(grid):
    return np.zeros(grid.frequency.size, complex)


def test_twice_the_unevenness_gives_twice_every_value(amplitudes, silent, grid):
    """6.02 dB in each metric, to single precision; vdv too."""
    once = levels(amplitudes, silent, grid, 32)
    louder = [block._replace(value=2.0 * block.value) for block in amplitudes]
    twice = levels(louder, silent, grid, 32)
    for key, value in once.items():
        assert twice[key] == pytest.approx(2.0 * value, rel=1e-5), key


def test_quantiles_of_256_passages_are_those_of_many(amplitudes, silent, grid):
    """Within 0.4 dB for weighted and whole signals, and within 0.7 dB in one-third octaves.

    Two standard errors of a 95 % value, 2.1 s/√256 with s = 1.5 and 2.5 dB.
    """
    few = levels(amplitudes, silent, grid, 256)
    many = levels(amplitudes, silent, grid, 8192)
    for (metric, statistic), value in many.items():
        if statistic.startswith("q"):
            limit = 0.7 if metric.startswith("third-octave") else 0.4
            assert abs(20.0 * np.log10(few[metric, statistic] / value)) < limit, (metric, statistic)


def test_more_passages_keep_the_first_ones(amplitudes, silent, grid):
    wanted = list(signals(("ppv",), grid.frequency, BAND))
    few, many = (sampled_values(amplitudes, silent, grid, wanted, count, 1) for count in (16, 300))
    for reading, value in few.items():
        np.testing.assert_allclose(many[reading][:16], value, rtol=1e-6)


def test_the_seed_chooses_the_ensemble(amplitudes, silent, grid):
    one, other = (levels(amplitudes, silent, grid, 16, seed, ("ppv",)) for seed in (1, 2))
    assert one["ppv", "mean"] != other["ppv", "mean"]


def test_expectations_are_means_over_the_ensemble(amplitudes, silent, grid):
    """(E VDV⁴)^¼ against 4,096 passages, within 1 %: the fourth power scatters by a half."""
    wanted = list(signals(("vdv",), grid.frequency, BAND))
    values = sampled_values(amplitudes, silent, grid, wanted, 4096, 1)
    expected = expectations(amplitudes, silent, grid, wanted)
    for reading, value in values.items():
        assert np.mean(value.astype(float) ** 4) ** 0.25 == pytest.approx(expected[reading], rel=0.01)


def test_without_unevenness_all_passages_are_the_quasi_static_one(grid, silent):
    """A tone that swells and fades, read in closed form: the running rms of a slow tone follows it."""
    time = np.arange(4096) / 4096 / STEP
    shape = np.exp(-0.5 * ((time - 0.5 / STEP) / 1.5) ** 2) * np.sin(2.0 * np.pi * 20.0 * time)
    first = round(grid.frequency[0] / STEP)
    mean = 2.0 * np.fft.fft(1e-3 * shape)[first : first + grid.frequency.size] / 4096
    nothing = [Block(0, 0, np.zeros((1, grid.frequency.size), np.complex64), False, 0)]
    np.testing.assert_allclose(histories(mean, grid, 4096), 1e-3 * shape, atol=1e-8)
    values = levels(nothing, mean, grid, 16, metrics=("v-max-fast", "ppv"))
    assert values["ppv", "q0.05"] == pytest.approx(1e-3, rel=2e-3)
    assert values["ppv", "q0.05"] == pytest.approx(values["ppv", "q0.95"], rel=1e-6)
    # The window of 0.125 s loses little of 1.5 s, and ripples with twice the tone.
    ripple = 1.0 / np.hypot(1.0, 4.0 * np.pi * 20.0 * FAST)
    assert values["v-max-fast", "mean"] == pytest.approx(1e-3 * np.sqrt(0.5 * (1.0 + ripple)), rel=5e-3)
    # Between fewer samples the crest of the ripple is missed by 0.2 %.
    assert values["v-max-fast", "expected"] == pytest.approx(values["v-max-fast", "mean"], rel=4e-3)
