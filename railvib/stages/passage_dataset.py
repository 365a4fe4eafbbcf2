"""Random passages of one case by several approaches as one dataset."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from railvib.levels.running import SAMPLES_PER_PERIOD
from railvib.passage.ensemble import batches, sampled_lines
from railvib.passage.grid import Grid
from railvib.passage.levels import histories, samples_for
from railvib.passage.moments import over_time, variance_spectra
from railvib.passage.passage_levels import PassageLevels
from railvib.stages.passage_levels import PassageLevelsOfCase
from railvib.stages.stage import Load

if TYPE_CHECKING:
    import xarray


def passage_dataset(
    computed: Sequence[tuple[PassageLevelsOfCase, PassageLevels]], load: Load
) -> "xarray.Dataset":
    """Return histories, variances and levels of passages, as `railvib.predict_passage` does.

    Parameters
    ----------
    computed
        The stage of every approach, with its result. The stages differ in nothing else.
    load
        Returns the results of what the stages need.
    """
    import xarray

    variances, means, samples = [], [], []
    for stage, _levels in computed:
        time, variance, mean, velocity = _histories(stage, load)
        variances.append(variance)
        means.append(mean)
        samples.append(velocity)
    by_receiver = ("approach", "receiver", "time")
    level, metric, unit, statistic = _levels_by_name([levels for _stage, levels in computed])
    first = computed[0][0]
    return xarray.Dataset(
        {
            "variance": (by_receiver, variances, {"unit": "(m/s)2"}),
            "quasi_static": (by_receiver, means, {"unit": "m/s"}),
            "velocity": (("approach", "passage", "receiver", "time"), samples, {"unit": "m/s"}),
            "level": (("approach", "receiver", "metric", "statistic"), level, {"unit": "see unit"}),
        },
        coords={
            "approach": [stage.approach for stage, _levels in computed],
            "receiver": [receiver.title for receiver in first.receivers],
            "offset": ("receiver", [receiver.offset_m for receiver in first.receivers], {"unit": "m"}),
            "time": ("time", time, {"unit": "s"}),
            "passage": np.arange(first.passages),
            "metric": metric,
            "unit": ("metric", unit),
            "statistic": statistic,
        },
        attrs={"seed": first.seed, "component": "z"},
    )


def _histories(
    stage: PassageLevelsOfCase, load: Load
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return times, σ² and m over (receiver, time), and velocities (passage, receiver, time)."""
    random = stage.random_passage(load)
    grid, functions = random.grid, stage.functions(load)
    samples = samples_for(grid, float(grid.frequency[-1]), SAMPLES_PER_PERIOD)
    everything = np.ones(grid.frequency.size, complex)
    variance = np.empty((len(functions), samples))
    mean = np.empty((len(functions), samples))
    velocity = np.empty((stage.passages, len(functions), samples), np.float32)
    for row, (receiver, function) in enumerate(functions.items()):
        amplitudes, quasi_static = random.amplitudes(receiver, function), random.mean(function)
        spectra = variance_spectra(amplitudes, grid, [everything], grid.frequency.size)
        variance[row] = np.maximum(over_time(spectra, samples)[0], 0.0)
        mean[row] = histories(quasi_static, grid, samples)
        first = 0
        for batch, count in batches(stage.passages):
            lines = sampled_lines(amplitudes, grid, stage.seed, batch, count)
            lines += quasi_static.astype(np.complex64)
            velocity[first : first + count, row] = histories(lines, grid, samples)
            first += count
    return _times(grid, samples), variance, mean, velocity


def _times(grid: Grid, samples: int) -> np.ndarray:
    """Return the times of samples, s; the middle of the train passes at 0."""
    return np.asarray((np.arange(samples) / samples - 0.5) / grid.step)


def _levels_by_name(
    levels: Sequence[PassageLevels],
) -> tuple[np.ndarray, list[str], list[str], list[str]]:
    """Return levels (approach, receiver, metric, statistic), metrics, their units, and statistics."""
    first = levels[0]
    units = dict(zip(first.metric.tolist(), first.unit.tolist(), strict=True))
    statistics = sorted(set(first.statistic.tolist()))
    metrics = list(units)
    places = list(dict.fromkeys(zip(first.receiver.tolist(), map(str, first.offset_m), strict=True)))
    value = np.full((len(levels), len(places), len(metrics), len(statistics)), np.nan)
    for row, each in enumerate(levels):
        for number, receiver, offset, metric, statistic in zip(
            each.value, each.receiver, each.offset_m, each.metric, each.statistic, strict=True
        ):
            place = places.index((str(receiver), str(offset)))
            value[row, place, metrics.index(str(metric)), statistics.index(str(statistic))] = number
    return value, metrics, [units[metric] for metric in metrics], statistics
