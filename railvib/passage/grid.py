"""Where the sum of a passage is taken: lines of frequency, and wavenumbers of the unevenness.

The lines f_j are multiples of one step up to v/(8L), so that a record lasts 1/Δf, eight passages or more.
The wavenumbers β_n lie at s(β_n) = n + ½ of

    s(β) = (X β + B arsinh(β/β_c))/2π,        Δβ = 1/s'(β)

Their sum is as good as an integral as soon as 2π/Δβ exceeds the length of the train and the line that is
heard together: X is that at high frequencies, and B/β grows with the wavelength, because a damped wave
reaches a number of wavelengths.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from railvib.numerics import third_octaves
from railvib.parameters.ground import Ground

AT_ONCE = 256
"""Passages that are sampled together."""
_REACH = 200.0
"""Line beyond the train that is heard at high frequencies, m."""
_DECAY = 2.0
"""Exponent of decay over half the line that is heard at low frequencies."""
_MOST_STRETCH = 4096.0
"""Largest B: less damped grounds are summed as if they were damped so much."""
_NEWTON_STEPS = 60
_STEPS_PER_RIPPLE = 8
"""Steps of the lines in the period v/L with which spectra ripple."""
_COARSEST_STEP = 0.125
"""Hz."""


@dataclass(frozen=True)
class Grid:
    """Lines and wavenumbers of a passage.

    Attributes
    ----------
    frequency
        Lines f_j, Hz, (lines,), multiples of their step.
    step
        Step of the lines, Hz.
    period
        X, m.
    stretch
        B, 1.
    corner
        β_c, rad/m.
    largest
        Largest wavenumber, rad/m.
    """

    frequency: np.ndarray
    step: float
    period: float
    stretch: float
    corner: float
    largest: float

    @cached_property
    def wavenumber(self) -> np.ndarray:
        """β_n, rad/m, (n,), ascending."""
        return self.wavenumber_at(np.arange(int(self.place(np.array(self.largest)))) + 0.5)

    @cached_property
    def width(self) -> np.ndarray:
        """Δβ_n, rad/m, (n,)."""
        beta = self.wavenumber
        return np.asarray(2.0 * np.pi / (self.period + self.stretch / np.hypot(beta, self.corner)))

    def place(self, beta: np.ndarray) -> np.ndarray:
        """Return s(β) of wavenumbers in rad/m."""
        return np.asarray(
            (self.period * beta + self.stretch * np.arcsinh(beta / self.corner)) / (2.0 * np.pi)
        )

    def wavenumber_at(self, place: np.ndarray) -> np.ndarray:
        """Return β of values of s, by Newton's method: s is concave, and rises without end."""
        beta = np.zeros(place.shape)
        for _ in range(_NEWTON_STEPS):
            slope = (self.period + self.stretch / np.hypot(beta, self.corner)) / (2.0 * np.pi)
            change = (place - self.place(beta)) / slope
            beta = beta + change
            if np.all(np.abs(change) <= 1e-14 * beta):
                break
        return beta


def passage_lines(band: Sequence[float], train_length: float, speed: float) -> np.ndarray:
    """Return the lines of a passage between the edges of its bands, Hz, (lines,).

    Parameters
    ----------
    band
        One-third octaves, exact midbands, Hz, ascending and adjoining.
    train_length, speed
        m, m/s.
    """
    lower, upper = third_octaves.edges(band)
    step = 1.0 / _canonical(1.0 / min(speed / (_STEPS_PER_RIPPLE * train_length), _COARSEST_STEP))
    return np.asarray(step * np.arange(np.ceil(lower[0] / step), np.floor(upper[-1] / step) + 1.0))


def passage_grid(
    ground: Ground,
    train_length: float,
    speed: float,
    band: Sequence[float],
    highest_excitation: float,
    refinement: int = 1,
) -> Grid:
    """Return the grid of a passage.

    X, B and β_c are powers of two, or one and a half times these: so that cases that differ a little have
    the same wavenumbers, and the same random unevenness.

    Parameters
    ----------
    ground
        The ground, whose waves reach far where its damping is low.
    train_length, speed
        m, m/s.
    band
        One-third octaves that the lines cover, exact midbands, Hz, ascending and adjoining.
    highest_excitation
        Highest frequency of excitation, Hz.
    refinement
        For studies of convergence: number by which X and B are multiplied.
    """
    frequency = passage_lines(band, train_length, speed)
    step = float(frequency[1] - frequency[0])
    # Over the reach x a wave decays by e^{-kηx/2}, k = βv/c: the slowest carries most, and decays fastest.
    damped = 4.0 * _DECAY * max(layer.shear_speed / (speed * layer.loss_factor) for layer in ground.layers)
    return Grid(
        frequency=frequency,
        step=step,
        period=refinement * _canonical(train_length + _REACH),
        stretch=refinement * min(_canonical(damped), _MOST_STRETCH),
        corner=_canonical(np.pi * float(frequency[0]) / speed),
        largest=2.0 * np.pi * highest_excitation / speed,
    )


def _canonical(value: float) -> float:
    """Return the smallest of 2ⁿ and 1.5·2ⁿ that is not below a positive value."""
    power = 2.0 ** np.floor(np.log2(value))
    return float(next(size for size in (power, 1.5 * power, 2.0 * power) if size >= value * (1.0 - 1e-12)))
