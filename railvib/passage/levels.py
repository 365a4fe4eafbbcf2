"""Levels of a passage: metrics of sampled passages, their statistics, and expectations that are exact."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import fft

from railvib.levels import running
from railvib.passage.amplitudes import Block
from railvib.passage.ensemble import batches, sampled_lines
from railvib.passage.grid import Grid
from railvib.passage.metrics import Reading, Signal
from railvib.passage.moments import over_time, variance_spectra

_PEAK_SAMPLES = 9.0
"""Samples per period of the highest frequency for peaks and doses."""
_READ_AT_ONCE = 16
"""Passages whose histories are in memory together: few enough to stay in the cache."""
LARGEST_DIFFERENCE = 32.0
"""Highest frequency of the variance over time, Hz: a Fast running mean passes 4 % of it."""


class Level(NamedTuple):
    """One statistic of one metric."""

    metric: str
    statistic: str
    """``mean``, ``expected``, or ``q`` with the quantile."""
    value: float
    unit: str


def sampled_values(
    amplitudes: Sequence[Block],
    mean: np.ndarray,
    grid: Grid,
    wanted: Sequence[Signal],
    passages: int,
    seed: int,
) -> dict[Reading, np.ndarray]:
    """Return the values of metrics in sampled passages, (passages,) each.

    Parameters
    ----------
    amplitudes
        Amplitudes of a receiver.
    mean
        M_j of the quasi-static part, complex (lines,), m/s.
    grid
        Lines and wavenumbers.
    wanted
        Weighted velocities, and what is read from them.
    passages
        How many.
    seed
        Seed of the ensemble.
    """
    values: dict[Reading, list[np.ndarray]] = {reading: [] for each in wanted for reading in each.readings}
    for batch, count in batches(passages):
        lines = sampled_lines(amplitudes, grid, seed, batch, count)
        lines += mean.astype(np.complex64)
        for each in wanted:
            for first in range(0, count, _READ_AT_ONCE):
                for reading, value in _read(lines[first : first + _READ_AT_ONCE], grid, each).items():
                    values[reading].append(value)
    return {reading: np.concatenate(parts) for reading, parts in values.items()}


def histories(lines: np.ndarray, grid: Grid, samples: int) -> np.ndarray:
    """Return velocities over the record from their lines, (..., samples)."""
    first = round(grid.frequency[0] / grid.step)
    spectrum = np.zeros((*lines.shape[:-1], samples // 2 + 1), lines.dtype)
    spectrum[..., first : first + lines.shape[-1]] = lines * (0.5 * samples)
    return np.asarray(fft.irfft(spectrum, samples))


def samples_for(grid: Grid, highest: float, per_period: float) -> int:
    """Return the number of samples of a record up to a frequency in Hz."""
    return int(fft.next_fast_len(int(np.ceil(per_period * highest / grid.step)), real=True))


def _read(lines: np.ndarray, grid: Grid, signal: Signal) -> dict[Reading, np.ndarray]:
    """Return what is read from sampled passages (passages, lines)."""
    fine = any(reading.kind != "running" for reading in signal.readings)
    highest = float(grid.frequency[signal.lines][-1])
    samples = samples_for(grid, highest, _PEAK_SAMPLES if fine else running.SAMPLES_PER_PERIOD)
    step = 1.0 / (grid.step * samples)
    weighted = np.zeros((lines.shape[0], signal.lines.stop), np.complex64)
    weighted[:, signal.lines] = lines[:, signal.lines] * signal.response[signal.lines].astype(np.complex64)
    history = histories(weighted, grid, samples)
    values = {}
    for reading in signal.readings:
        if reading.kind == "running":
            square = running.smoothed(np.square(history), step, reading.time_constant)
            values[reading] = running.running_maximum(square)
        elif reading.kind == "peak":
            values[reading] = running.peak(history)
        else:
            values[reading] = running.vdv(history, step)
    return values


def expectations(
    amplitudes: Sequence[Block], mean: np.ndarray, grid: Grid, wanted: Sequence[Signal]
) -> dict[Reading, float]:
    """Return √max E y(t) of running mean squares y, and (E VDV⁴)^¼, of signals over all lines.

    Parameters
    ----------
    amplitudes, mean, grid, wanted
        As for `sampled_values`; one-third octaves and peaks have no such expectation here.
    """
    broad = [each for each in wanted if each.lines == slice(0, grid.frequency.size)]
    count = int(LARGEST_DIFFERENCE / grid.step)
    spectra = variance_spectra(amplitudes, grid, [each.response for each in broad], count)
    samples = samples_for(grid, float(grid.frequency[-1]), running.SAMPLES_PER_PERIOD)
    step = 1.0 / (grid.step * samples)
    expected = {}
    for each, spectrum in zip(broad, spectra, strict=True):
        variance = over_time(spectrum, samples)
        square = histories(mean * each.response, grid, samples) ** 2
        for reading in each.readings:
            if reading.kind == "running":
                smooth = running.smoothed(variance + square, step, reading.time_constant)
                expected[reading] = float(np.sqrt(smooth.max()))
            elif reading.kind == "dose":
                fourth = 3.0 * variance**2 + 6.0 * variance * square + square**2
                expected[reading] = float((fourth.sum() * step) ** 0.25)
    return expected


def statistics(
    values: dict[Reading, np.ndarray], expected: dict[Reading, float], quantiles: Sequence[float]
) -> list[Level]:
    """Return the mean, the expectation and the quantiles of metrics."""
    levels = []
    for reading, value in values.items():
        levels.append(Level(reading.name, "mean", float(value.mean(dtype=float)), reading.unit))
        if reading in expected:
            levels.append(Level(reading.name, "expected", expected[reading], reading.unit))
        for quantile, at in zip(quantiles, np.quantile(value, quantiles), strict=True):
            levels.append(Level(reading.name, f"q{quantile:g}", float(at), reading.unit))
    return levels
