"""Receptances of distant axles without their fast phases, which can be interpolated over frequency.

Two contributions turn fast with frequency. A wave of slowness s reaches a distance d with the phase
e^{−iωs'|d|}, s' = s/(1 ∓ sv) ahead of the load and behind it. And at β = ω/v, where the track sees zero
frequency, the hysteretic damping changes its sign: the response jumps by twice its imaginary part I, which
leaves

    T(d, ω) = (I/π) e^{iωd/v} d/(a² + d²),        a = v/ω

to leading order in a/d. T decays so slowly that it dominates beyond some 50 m.
"""

from typing import NamedTuple

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_interpolation import interpolate
from railvib.numerics.vector_math import phasors
from railvib.parameters.track import Track
from railvib.transfer.track_response import track_response
from railvib.transfer.transfer_function import TransferFunction

_SHARES = np.array([0.0, 0.5, 0.6, 0.7, 0.4, 0.3])
"""Slownesses whose phase is tried, over that at u = 1, in order of trial."""
_SMALLEST_DENOMINATOR = 0.2
"""Lower bound of 1 − sv: a load that outruns a wave has it behind only, and no phase helps ahead."""


class Load(NamedTuple):
    """A load on the rail, and the distances from it at which receptances are wanted."""

    rail: TransferFunction
    track: Track
    speed: float
    """m/s."""
    distance: np.ndarray
    """Ahead of the load, m, (m,)."""

    def sign_change(self, frequency: np.ndarray) -> np.ndarray:
        """Return T at frequencies (n,) in Hz, complex (n, m), m/N."""
        if self.speed == 0.0:
            return np.zeros((frequency.size, self.distance.size), complex)
        beta = 2.0 * np.pi * frequency / self.speed
        static = np.full(beta.size, 2.0 * np.pi * self.rail.lowest)
        response = self.rail.response(beta, static)
        beyond = beta > self.rail.reach
        if beyond.any():
            response[beyond] = track_response(self.track, beta[beyond], static[beyond], 0.0)[0]
        angle = beta[:, None] * self.distance
        share = (response.imag * beta / np.pi)[:, None] * angle / (1.0 + angle**2)
        return np.asarray(share * phasors(angle))

    def phase(self, frequency: np.ndarray, slowness: float) -> np.ndarray:
        """Return e^{iωs'|d|} of waves of a slowness in s/m, complex (n, m)."""
        ahead = slowness / max(1.0 - slowness * self.speed, _SMALLEST_DENOMINATOR)
        behind = slowness / (1.0 + slowness * self.speed)
        delay = np.where(self.distance > 0.0, ahead, behind) * np.abs(self.distance)
        return phasors(2.0 * np.pi * frequency[:, None] * delay)


class Reduced(NamedTuple):
    """Receptances at the frequencies of one block, without their fast phases."""

    load: Load
    block: int
    level: int
    slowness: float
    """Slowness of the waves whose phase is taken out, s/m; 0 for none."""
    rows: np.ndarray
    """Complex (frequencies, m)."""

    @classmethod
    def of(cls, load: Load, block: int, level: int, slowness: float, rows: np.ndarray) -> "Reduced":
        """Return receptances without T at the frequencies of a block, and take a wave's phase out."""
        if slowness > 0.0:
            rows = rows * load.phase(blocks.frequency(level, blocks.indices(block, level)), slowness)
        return cls(load, block, level, slowness, rows)

    def without_sign_change(self, frequency: np.ndarray) -> np.ndarray:
        """Interpolate receptances without T to frequencies (n,) inside the block, Hz: (n, m)."""
        value = interpolate(self.block, self.level, frequency, self.rows)
        if self.slowness > 0.0:
            value *= self.load.phase(frequency, self.slowness).conj()
        return np.asarray(value)

    def at(self, frequency: np.ndarray) -> np.ndarray:
        """Interpolate receptances to frequencies (n,) inside the block, Hz: (n, m)."""
        return np.asarray(self.without_sign_change(frequency) + self.load.sign_change(frequency))


def remove_fast_phases(
    load: Load,
    block: int,
    level: int,
    receptance: np.ndarray,
    between: np.ndarray,
    direct: np.ndarray,
    good_enough: float,
) -> tuple[Reduced, float]:
    """Return receptances without the phases whose removal makes them smoothest, and the remaining error.

    Parameters
    ----------
    load
        The load and the distances, 0 the last of them.
    block, level
        Block and level of the frequencies.
    receptance
        Receptances at them, complex (frequencies, m), m/N.
    between
        Frequencies at which interpolation is checked, Hz, (n,).
    direct
        Receptances at these, (n, m).
    good_enough
        Error, relative to the receptance at the load, below which no other phase is tried.
    """
    frequency = blocks.frequency(level, blocks.indices(block, level))
    rows, exact = receptance - load.sign_change(frequency), direct - load.sign_change(between)
    best = Reduced(load, block, level, 0.0, rows), np.inf
    for slowness in _SHARES * max(table.nodes.top_slowness for table in load.rail.blocks.values()):
        reduced = Reduced.of(load, block, level, float(slowness), rows)
        difference = np.abs(reduced.without_sign_change(between) - exact)
        error = float((difference / np.abs(direct[:, -1:])).max())
        if error < best[1]:
            best = reduced, error
        if error <= good_enough:
            break
    return best
