"""What turns fast with frequency in the receptances of distant axles, taken out where they are interpolated.

Two things do. A wave of slowness s reaches a distance d with the phase e^{−iωs'|d|}, s' = s/(1 ∓ sv) ahead of
the load and behind it. And at β = ω/v, where the track sees no frequency, the hysteretic damping changes its
sign: the response jumps by twice its imaginary part I, which leaves

    T(d, ω) = (I/π) e^{iωd/v} d/(a² + d²),        a = v/ω

to leading order in a/d. It decays so slowly that beyond some 50 m it outlasts the waves.
"""

from typing import NamedTuple

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.vector_math import turned
from railvib.parameters.track import Track
from railvib.transfer.track_response import track_response
from railvib.transfer.transfer_function import TransferFunction

_SHARES = np.array([0.0, 0.5, 0.6, 0.7, 0.4, 0.3])
"""Slownesses whose phase is tried, of one above every wave's."""
_NEAREST_TO_CRITICAL = 0.2
"""1 − sv is not taken below: a load that outruns a wave has it behind only, and no phase helps ahead."""


class Load(NamedTuple):
    """A load on the rail and the distances from it at which receptances are wanted."""

    rail: TransferFunction
    track: Track
    speed: float
    """m/s."""
    distance: np.ndarray
    """Ahead of the load, m, (m,)."""

    def dragged(self, frequency: np.ndarray) -> np.ndarray:
        """Return T at frequencies (n,) in Hz, complex (n, m), m/N."""
        if self.speed == 0.0:
            return np.zeros((frequency.size, self.distance.size), complex)
        turn = 2.0 * np.pi * frequency / self.speed
        static = np.full(turn.size, 2.0 * np.pi * self.rail.lowest)
        response = self.rail.response(turn, static)
        beyond = turn > self.rail.reach
        if beyond.any():
            response[beyond] = track_response(self.track, turn[beyond], static[beyond], 0.0)[0]
        angle = turn[:, None] * self.distance
        share = (response.imag * turn / np.pi)[:, None] * angle / (1.0 + angle**2)
        return np.asarray(share * turned(angle))

    def phase(self, frequency: np.ndarray, slowness: float) -> np.ndarray:
        """Return e^{iωs'|d|} of waves of a slowness in s/m, complex (n, m)."""
        ahead = slowness / max(1.0 - slowness * self.speed, _NEAREST_TO_CRITICAL)
        behind = slowness / (1.0 + slowness * self.speed)
        away = np.where(self.distance > 0.0, ahead, behind) * np.abs(self.distance)
        return turned(2.0 * np.pi * frequency[:, None] * away)


class Reduced(NamedTuple):
    """Receptances at the frequencies of one block without what turns fast."""

    load: Load
    block: int
    level: int
    slowness: float
    """Of the waves whose phase is taken out, s/m."""
    rows: np.ndarray
    """Complex (frequencies, m)."""

    def at(self, frequency: np.ndarray) -> np.ndarray:
        """Interpolate receptances to frequencies (n,) inside the block, Hz: (n, m)."""
        value = blocks.interpolated(self.block, self.level, frequency, self.rows)
        if self.slowness > 0.0:
            value *= self.load.phase(frequency, self.slowness).conj()
        return np.asarray(value + self.load.dragged(frequency))


def smoothest(
    load: Load,
    block: int,
    level: int,
    receptance: np.ndarray,
    between: np.ndarray,
    direct: np.ndarray,
    enough: float,
) -> tuple[Reduced, float]:
    """Return receptances without the phases that let them be interpolated best, and the error that is left.

    Parameters
    ----------
    load
        The load and the distances, 0 the last of them.
    block, level
        Of the frequencies.
    receptance
        Receptances at them, complex (frequencies, m), m/N.
    between
        Frequencies at which interpolation is checked, Hz, (n,).
    direct
        Receptances at these, (n, m).
    enough
        Error, relative to the receptance at the load, below which no other phase is tried.
    """
    frequency = blocks.frequency(level, blocks.indices(block, level))
    rows, exact = receptance - load.dragged(frequency), direct - load.dragged(between)
    best = Reduced(load, block, level, 0.0, rows), np.inf
    for slowness in _SHARES * max(table.nodes.top_slowness for table in load.rail.blocks.values()):
        turned = rows * load.phase(frequency, slowness) if slowness > 0.0 else rows
        value = blocks.interpolated(block, level, between, turned)
        if slowness > 0.0:
            value *= load.phase(between, slowness).conj()
        error = float((np.abs(value - exact) / np.abs(direct[:, -1:])).max())
        if error < best[1]:
            best = Reduced(load, block, level, slowness, turned), error
        if error <= enough:
            break
    return best
