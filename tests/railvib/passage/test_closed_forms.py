"""Closed forms against sampled passages, and where they are exact."""

import numpy as np
import pytest
from scipy import stats

from railvib.levels.running import FAST
from railvib.passage import closed_forms
from railvib.passage.closed_forms import RunningShape
from railvib.passage.closed_levels import closed_levels
from railvib.passage.levels import sampled_values, statistics
from railvib.passage.metrics import signals
from tests.railvib.passage.test_levels import BAND, QUANTILES, amplitudes, grid, silent

__all__ = ["amplitudes", "grid", "silent"]

LIMITS = {"wide": {"q0.5": 1.0, "q0.95": 0.7}, "narrow": {"q0.5": 2.3, "q0.95": 1.7}}
"""dB, of medians and 95 % values: largest deviations seen in synthetic and predicted passages."""


def test_maxima_are_near_those_of_samples(amplitudes, silent, grid):
    metrics = ("v-max-fast", "v-max-slow", "kb-f-max", "ppv", "third-octave-max-fast")
    wanted = list(signals(metrics, grid.frequency, BAND))
    sampled = statistics(sampled_values(amplitudes, silent, grid, wanted, 2048, 1), {}, QUANTILES)
    values = {(row.metric, row.statistic): row.value for row in sampled}
    compared = 0
    for row in closed_levels(amplitudes, silent, grid, wanted, QUANTILES):
        limits = LIMITS["narrow" if row.metric.startswith("third-octave") else "wide"]
        if row.statistic in limits:
            error = 20.0 * np.log10(row.value / values[row.metric, row.statistic])
            assert abs(error) < limits[row.statistic], row
            compared += 1
    assert compared == 2 * (4 + BAND.size)


def test_running_shape_of_a_wide_band():
    """ε² = 1/(2Bτ) and θ = τ, where 1/B is small beside τ, here 0.8 %: to 1 %."""
    step, bandwidth = 0.1, 1000.0
    psd = np.ones(int(bandwidth / step))
    shape = closed_forms.running_shape(psd, 100, step, FAST)
    assert shape.spread == pytest.approx(1.0 / (2.0 * bandwidth * FAST), rel=0.01)
    assert shape.scale == pytest.approx(FAST, rel=0.01)


def test_a_single_moment_has_the_gamma_distribution():
    """Of a narrow signal that lasts as long as its values are related, the maximum is one value of y.

    To 0.5 %: the distribution is linear between levels that are 5 % of the rms apart.
    """
    shape = RunningShape(0.5, 2.0)
    distribution = closed_forms.running_maximum_of_narrow(np.ones(1), 1.0, shape)
    exact = np.sqrt(stats.gamma(2.0, scale=0.5).ppf(QUANTILES))
    np.testing.assert_allclose([distribution.quantile(each) for each in QUANTILES], exact, rtol=5e-3)


def test_mean_of_a_distribution():
    level = np.linspace(1.0, 3.0, 201)
    uniform = closed_forms.Distribution(level, (level - 1.0) / 2.0)
    assert uniform.mean == pytest.approx(2.0)
    assert uniform.quantile(0.25) == pytest.approx(1.5)


def test_peaks_of_wide_noise_are_those_of_rice_at_high_levels():
    """P(peak ≤ b) → exp(−2ν T e^{−b²/2σ²}): in its tail to 2 %."""
    count, step, frequency = 1000, 0.01, 20.0
    second = np.full(count, (2.0 * np.pi * frequency) ** 2)
    distribution = closed_forms.peak(np.ones(count), np.zeros(count), second, np.zeros(count), step)
    level = distribution.quantile(0.99)
    crossings = 2.0 * frequency * count * step * np.exp(-0.5 * level**2)
    assert np.exp(-crossings) == pytest.approx(0.99, abs=2e-3)
