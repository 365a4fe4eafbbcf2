"""Levels of a passage in closed form: the choice of large sweeps, which sample no passages."""

from collections.abc import Sequence

import numpy as np

from railvib.levels import running
from railvib.passage import closed_forms
from railvib.passage.amplitudes import Block, line_energies
from railvib.passage.closed_forms import Distribution
from railvib.passage.grid import Grid
from railvib.passage.levels import LARGEST_DIFFERENCE, Level, expectations, histories, samples_for
from railvib.passage.metrics import Reading, Signal
from railvib.passage.moments import over_time, variance_spectra


def closed_levels(
    amplitudes: Sequence[Block],
    mean: np.ndarray,
    grid: Grid,
    wanted: Sequence[Signal],
    quantiles: Sequence[float],
) -> list[Level]:
    """Return means, expectations and quantiles of metrics; of a dose the expectation alone is known.

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
    quantiles
        Over realisations of the unevenness.
    """
    expected = expectations(amplitudes, mean, grid, wanted)
    energy = line_energies(amplitudes, grid.frequency.size)
    levels = []
    for signal in wanted:
        distributions = _distributions(amplitudes, mean, grid, signal, energy)
        for reading in signal.readings:
            if reading in expected:
                levels.append(Level(reading.name, "expected", expected[reading], reading.unit))
            if reading in distributions:
                distribution = distributions[reading]
                levels.append(Level(reading.name, "mean", distribution.mean, reading.unit))
                levels += [
                    Level(reading.name, f"q{each:g}", distribution.quantile(each), reading.unit)
                    for each in quantiles
                ]
    return levels


def _distributions(
    amplitudes: Sequence[Block], mean: np.ndarray, grid: Grid, signal: Signal, energy: np.ndarray
) -> dict[Reading, Distribution]:
    response = np.zeros(grid.frequency.size, complex)
    response[signal.lines] = signal.response[signal.lines]
    highest = float(grid.frequency[signal.lines][-1])
    samples = samples_for(grid, highest, running.SAMPLES_PER_PERIOD)
    step = 1.0 / (grid.step * samples)
    over_highest = grid.frequency / highest
    # λ₁ follows from the sum of a signal and its derivative.
    peaks = any(reading.kind == "peak" for reading in signal.readings)
    responses = [response, response * over_highest, response * (1.0 + over_highest)][: 3 if peaks else 1]
    spectra = variance_spectra(amplitudes, grid, responses, int(LARGEST_DIFFERENCE / grid.step))
    moments = np.maximum(over_time(spectra, samples), 0.0)
    history = histories((mean * response)[: signal.lines.stop], grid, samples)
    wide = signal.lines == slice(0, grid.frequency.size)
    first = round(grid.frequency[0] / grid.step)
    distributions = {}
    for reading in signal.readings:
        if reading.kind == "running":
            shape = closed_forms.running_shape(
                energy * np.abs(response) ** 2, first, grid.step, reading.time_constant
            )
            smooth = running.smoothed(moments[0] + history**2, step, reading.time_constant)
            form = closed_forms.running_maximum_of_wide if wide else closed_forms.running_maximum_of_narrow
            distributions[reading] = form(smooth, step, shape)
        elif reading.kind == "peak":
            per_second = 2.0 * np.pi * highest
            turning = 0.5 * (moments[2] - moments[0] - moments[1]) * per_second
            distributions[reading] = closed_forms.peak(
                moments[0], turning, moments[1] * per_second**2, history, step
            )
    return distributions
