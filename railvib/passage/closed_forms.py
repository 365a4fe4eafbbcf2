"""Distributions of a passage's maxima in closed form, without sampling.

A running mean square y of many degrees of freedom has a gamma distribution of shape 1/ε², ε² = Var y/E²y. Of
a wide signal it moves as an Ornstein–Uhlenbeck process of integral scale θ, and its standard normal
equivalent z crosses a level at the rate z φ(z)/θ. Of a one-third octave, whose y has few degrees of freedom,
the maximum is that of independent values θ/2 apart. Peaks follow Vanmarcke (1975) with the variance, λ₁ and
λ₂ of every moment. How far they are from sampled passages: docs/theory/passage.md.
"""

from typing import NamedTuple

import numpy as np
from scipy import fft, special

_LEVELS = 240
"""Levels at which a distribution is computed."""
_RANGE = (0.2, 12.0)
"""Lowest and highest level over the largest expected rms."""
_TIMES_PER_SCALE = 16
"""Times in an integral scale at which the distribution of a running mean square is computed."""
_CLUMPING = 1.2
"""Vanmarcke's exponent of the bandwidth."""


class Distribution(NamedTuple):
    """A distribution function at ascending levels."""

    level: np.ndarray
    probability: np.ndarray
    """That the value is not above the level."""

    def quantile(self, probability: float) -> float:
        """Return the level that is not exceeded with a probability."""
        return float(np.interp(probability, self.probability, self.level))

    @property
    def mean(self) -> float:
        """The mean."""
        above = 1.0 - self.probability
        return float(self.level[0] + np.trapezoid(above, self.level))


class RunningShape(NamedTuple):
    """How a running mean square scatters and moves."""

    spread: float
    """ε² = Var y/E²y."""
    scale: float
    """θ, integral scale, s."""


def running_shape(psd: np.ndarray, first: int, step: float, time_constant: float) -> RunningShape:
    """Return the shape of the exponential running mean square of a stationary signal.

    Parameters
    ----------
    psd
        One-sided PSD on even lines, (lines,), in any unit.
    first
        Index of the first line, in steps from 0 Hz.
    step
        Of the lines, Hz.
    time_constant
        τ, s.
    """
    size = int(fft.next_fast_len(4 * (first + psd.size), real=True))
    spectrum = np.zeros(size // 2 + 1)
    spectrum[first : first + psd.size] = psd
    correlation = fft.irfft(spectrum, size)
    squared = 2.0 * (correlation / correlation[0]) ** 2
    power = fft.rfft(squared).real / (step * size)
    frequency = step * np.arange(power.size)
    smooth = power / (1.0 + (2.0 * np.pi * frequency * time_constant) ** 2)
    variance = step * (2.0 * smooth.sum() - smooth[0])
    return RunningShape(float(variance), float(0.5 * smooth[0] / variance))


def running_maximum_of_wide(expected: np.ndarray, step: float, shape: RunningShape) -> Distribution:
    """Return the distribution of the largest running rms of a wide signal.

    Parameters
    ----------
    expected
        E y(t) at even times, (n,).
    step
        Between the times, s.
    shape
        Of the running mean square.
    """
    expected, step = _thinned(expected, step, shape)
    level, within = _within(expected, shape)
    z = special.ndtri(np.clip(within, 1e-300, 1.0 - 1e-16))
    rate = np.maximum(z, 0.0) * np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi) / shape.scale
    return _distribution(level, within.min(axis=1) * np.exp(-rate.sum(axis=1) * step))


def running_maximum_of_narrow(expected: np.ndarray, step: float, shape: RunningShape) -> Distribution:
    """Return the distribution of the largest running rms of a one-third octave.

    Parameters
    ----------
    expected, step, shape
        As for `running_maximum_of_wide`.
    """
    expected, step = _thinned(expected, step, shape)
    level, within = _within(expected, shape)
    share = min(2.0 * step / shape.scale, 1.0)
    return _distribution(level, np.exp(share * np.log(np.maximum(within, 1e-300)).sum(axis=1)))


def peak(
    variance: np.ndarray, first_moment: np.ndarray, second_moment: np.ndarray, mean: np.ndarray, step: float
) -> Distribution:
    """Return the distribution of the largest absolute value.

    Parameters
    ----------
    variance, first_moment, second_moment
        σ², λ₁ and λ₂ at even times, (n,): rad/s and (rad/s)² times the variance.
    mean
        m(t), (n,).
    step
        Between the times, s.
    """
    counted = variance > 1e-8 * variance.max()
    variance, first_moment, second_moment = (
        part[counted] for part in (variance, first_moment, second_moment)
    )
    sigma = np.sqrt(variance)
    crossings = np.sqrt(second_moment / variance) / (2.0 * np.pi)
    narrow = np.clip(1.0 - first_moment**2 / (variance * second_moment), 0.0, 1.0)
    clumping = np.sqrt(0.5 * np.pi) * narrow ** (0.5 * _CLUMPING)
    level = np.linspace(*_RANGE, _LEVELS) * float(np.sqrt(variance + mean[counted] ** 2).max())
    ratio = np.maximum((level[:, None] - np.abs(mean[counted])) / sigma, 1e-6)
    outside = np.exp(-0.5 * ratio**2)
    rate = 2.0 * crossings * outside * -np.expm1(-clumping * ratio) / np.maximum(1.0 - outside, 1e-300)
    return _distribution(level, (1.0 - outside).min(axis=1) * np.exp(-rate.sum(axis=1) * step))


def _thinned(expected: np.ndarray, step: float, shape: RunningShape) -> tuple[np.ndarray, float]:
    """Return the largest value in every stretch of times that is short beside θ, and the stretches' step."""
    times = max(int(shape.scale / (_TIMES_PER_SCALE * step)), 1)
    count = expected.size // times
    return expected[: count * times].reshape(count, times).max(axis=1), times * step


def _within(expected: np.ndarray, shape: RunningShape) -> tuple[np.ndarray, np.ndarray]:
    """Return levels, (levels,), and P(y(t) ≤ level²) at every time, (levels, n)."""
    counted = expected[expected > 1e-4 * expected.max()]
    level = np.linspace(*_RANGE, _LEVELS) * float(np.sqrt(counted.max()))
    freedom = 1.0 / shape.spread
    within = special.gammainc(freedom, freedom * level[:, None] ** 2 / counted)
    return level, np.asarray(within)


def _distribution(level: np.ndarray, probability: np.ndarray) -> Distribution:
    return Distribution(level, np.maximum.accumulate(np.clip(probability, 0.0, 1.0)))
