"""The narrow-band lines of a case, and mean squares of spectra in one-third octaves.

Each one-third octave is divided evenly, and its edges are lines. So its mean square follows from lines inside
it alone: a band's level does not depend on which other bands are asked for, and no transfer function is
needed beyond the edges.

A spectrum ripples with the period v/L of the train's passage, and near a resonance of a vehicle it changes
as fast as the resonance is wide. The number of intervals of a band is the least 2ⁿ or 3·2ⁿ that resolves
both, so that neighbouring speeds share their lines.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railvib.errors import InputError
from railvib.numerics import third_octaves
from railvib.parameters.vehicle import Train

LINES_AT_ONCE = 128
"""Lines whose matrices of axles are in memory at once: few enough to stay in the cache."""
_STEPS_PER_RIPPLE = 8
"""Steps in the period v/L of the ripple, which leave 0.002 dB in bands."""
_STEPS_PER_MODE = 2
"""Steps in the distance, in the plane of complex frequency, between a band and a vehicle's resonance."""
_SHARPEST = 0.002
"""Least half width of a resonance over its frequency: undamped suspensions are damped by the track."""
_FEWEST_INTERVALS = 24
"""Of a band, over which the response to a load that moves steadily far away falls by up to 50 dB."""


@dataclass(frozen=True)
class Lines:
    """Narrow-band lines over adjoining one-third octaves.

    Attributes
    ----------
    band
        Exact midband frequencies, Hz, ascending.
    intervals
        How many parts each band is divided into.
    """

    band: tuple[float, ...]
    intervals: tuple[int, ...]

    @cached_property
    def frequency(self) -> NDArray[np.float64]:
        """The lines, Hz, (n,), ascending; bands share the line at their common edge."""
        lower, upper = third_octaves.edges(self.band)
        shares = [np.arange(number) / number for number in self.intervals]
        parts = [low + (high - low) * share for low, high, share in zip(lower, upper, shares, strict=True)]
        return np.concatenate([*parts, upper[-1:]])

    def mean_squares(self, psd: ArrayLike) -> NDArray[np.float64]:
        """Return the integral of one-sided power spectral densities over each band.

        Parameters
        ----------
        psd
            Densities per Hz on the lines, (..., n), not negative.

        Returns
        -------
        ndarray, shape (..., bands)

        Raises
        ------
        InputError
            If the densities do not fit the lines, are negative or not finite.

        Notes
        -----
        By `third_octaves.integrate`, which is local on purpose: a spline, or a difference of running
        integrals, spreads the rounding and the ringing of the largest values over a spectrum that spans many
        decades.
        """
        density = np.asarray(psd, dtype=np.float64)
        if density.shape[-1:] != self.frequency.shape:
            raise InputError(
                f"psd of shape {density.shape}: its last axis must fit the {self.frequency.size} lines"
            )
        if not np.all(np.isfinite(density)) or np.any(density < 0.0):
            raise InputError("psd: must be finite and not negative")
        lower, upper = third_octaves.edges(self.band)
        mean_square = np.empty((*density.shape[:-1], len(self.band)))
        first = 0
        for place, number in enumerate(self.intervals):
            step = (upper[place] - lower[place]) / number
            inside = density[..., first : first + number + 1]
            mean_square[..., place] = step * third_octaves.integrate(inside)
            first += number
        return mean_square


@lru_cache(4096)
def lines(band: tuple[float, ...], train: Train, speed: float, refinement: int = 1) -> Lines:
    """Return the lines that resolve the spectra of a train's passage.

    Parameters
    ----------
    band
        Exact midband frequencies, Hz, ascending.
    train
        The train: its length, and the resonances of its vehicles.
    speed
        m/s.
    refinement
        For studies of convergence: 2 halves every step.
    """
    lower, upper = third_octaves.edges(band)
    step = np.minimum(speed / (_STEPS_PER_RIPPLE * train.length), (upper - lower) / _FEWEST_INTERVALS)
    for block in set(train.blocks):
        for mode in block.suspension_modes / (2.0 * np.pi):
            aside = np.maximum(np.maximum(lower - mode.imag, mode.imag - upper), 0.0)
            half_width = max(abs(mode.real), _SHARPEST * mode.imag)
            step = np.minimum(step, np.hypot(aside, half_width) / _STEPS_PER_MODE)
    needed = np.ceil((upper - lower) / step - 1e-9)
    octave = 2.0 ** np.ceil(np.log2(needed))
    number = np.where(0.75 * octave >= needed, 0.75 * octave, octave).astype(int) * refinement
    return Lines(tuple(float(midband) for midband in band), tuple(number.tolist()))
