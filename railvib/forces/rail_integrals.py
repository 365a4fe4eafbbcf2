"""Fourier integrals over wavenumber of the rail's response to loads that stand or move.

    ∫ H̃_R(β, ω − βv) e^{iβd} dβ

Panels have their edges at the slownesses of travelling waves, Doppler-shifted, and where ω − βv changes sign,
and the damping with it. A panel that does not resolve the response is halved. Beyond the tables the rail on
its pads carries the load alone.
"""

from typing import NamedTuple

import numpy as np

from railvib.forces._kernels.rail_integrals import integrate_panels
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.refinement import halve
from railvib.numerics.wavenumber_panels import NODE, series_tails
from railvib.parameters.track import Track
from railvib.transfer.track_response import track_response
from railvib.transfer.transfer_function import TransferFunction

_TAIL_PANELS = 3
_TAIL_RATIO = 4.0
"""End of each panel of the tail over its beginning. The tail is less than 1e-3 of the integral and falls with
the cube of where it begins: what is cut off is below 1e-8.
"""
_MOST_HALVINGS = 12
_EDGE_STRIDE = 3
"""One of so many edges of the tables is an edge here: the tables also resolve the ground at some distance."""
_NARROWEST = 0.01
"""Width of the narrowest panels in powers of two, rad/m, where no wave asks for narrower ones."""
_SIGN_CHANGE_REACH = 4.0
"""Farthest panel edges around the β at which ω − βv = 0, over that β; beyond, edges around β = 0 suffice."""
_RESOLVED = 1e-2
"""Last Legendre coefficients of a panel times its width, over tolerance times peak, at which it is resolved:
the remaining error is below 1e-2 of the tolerance.
"""


def rail_integrals(
    rail: TransferFunction,
    track: Track,
    speed: float,
    frequency: np.ndarray,
    distance: np.ndarray,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray, int]:
    """Return cosine and sine integrals of the rail's response to a load.

    Parameters
    ----------
    rail, track, speed
        As in `railvib.forces.receptance.receptances`.
    frequency
        Frequencies of the load, Hz, (n,), not negative.
    distance
        Distances, not negative and ascending, m, (m,).
    tolerance
        Relative error allowed.

    Returns
    -------
    cosine, sine : ndarray of complex, shape (n, m)
        ∫ H̃_R cos(βd) dβ and ∫ H̃_R sin(βd) dβ, m/N.
    number : int
        Number of wavenumbers at which the response was computed.

    Raises
    ------
    ValueError
        If a frequency that the track sees lies above the tables.
    """
    if speed == 0.0:  # below the tables the static limit
        frequency = np.maximum(frequency, rail.lowest)
    # The response to a standing load is even in β: its panels lie over β > 0 and count twice.
    sides = 2.0 if speed == 0.0 else 1.0
    panels, value = _resolve(rail, track, speed, frequency, tolerance)
    order = np.argsort(panels.owner, kind="stable")
    cosine = np.zeros((frequency.size, 2, distance.size))
    sine = np.zeros((frequency.size, 2, distance.size))
    integrate_panels(
        np.searchsorted(panels.owner[order], np.arange(frequency.size + 1)),
        order,
        panels.centre[order],
        panels.half[order],
        value.view(float),
        distance,
        cosine,
        sine,
    )
    even = sides * (cosine[:, 0] + 1j * cosine[:, 1])
    odd = sine[:, 0] + 1j * sine[:, 1] if speed != 0.0 else np.zeros_like(even)
    return even, odd, value.size


class _Panels(NamedTuple):
    """Panels of all frequencies, (panels,).

    They are kept by their half widths, so that both halves of a panel have the same to the last bit: what
    depends on the width alone then serves both.
    """

    owner: np.ndarray
    """Index of the frequency that a panel belongs to."""
    centre: np.ndarray
    half: np.ndarray

    def select(self, which: np.ndarray) -> "_Panels":
        """Return some of the panels."""
        return _Panels(self.owner[which], self.centre[which], self.half[which])

    def halves(self) -> "_Panels":
        """Return both halves of each panel, one after the other."""
        half = np.repeat(0.5 * self.half, 2)
        centre = np.repeat(self.centre, 2)
        centre[::2] -= half[::2]
        centre[1::2] += half[1::2]
        return _Panels(np.repeat(self.owner, 2), centre, half)


def _resolve(
    rail: TransferFunction, track: Track, speed: float, frequency: np.ndarray, tolerance: float
) -> tuple[_Panels, np.ndarray]:
    """Return panels that resolve the response, and the response at their nodes."""
    peak = np.zeros(frequency.size)

    def evaluate(panels: _Panels) -> tuple[np.ndarray, np.ndarray]:
        beta = panels.centre[:, None] + panels.half[:, None] * NODE
        seen = 2.0 * np.pi * frequency[panels.owner][:, None] - beta * speed
        tail = np.abs(panels.centre) > rail.reach
        if tail.any():
            value = np.empty(beta.shape, complex)
            value[~tail] = rail.response(beta[~tail], seen[~tail], into_halo=speed == 0.0)
            value[tail], _force = track_response(track, beta[tail], seen[tail], 0.0)
        else:
            value = rail.response(beta, seen, into_halo=speed == 0.0)
        if not peak.any():
            size = np.sqrt((np.square(value.real) + np.square(value.imag)).max(axis=1))
            np.maximum.at(peak, panels.owner, size)
        error = series_tails(value)[:, 0] * 2.0 * panels.half
        return value, error > _RESOLVED * tolerance * peak[panels.owner]

    parts = list(halve(_first_panels(rail, frequency, speed), evaluate, _MOST_HALVINGS))
    columns = zip(*(panels for panels, _value in parts), strict=True)
    return _Panels(*map(np.concatenate, columns)), np.concatenate([value for _panels, value in parts])


def _first_panels(rail: TransferFunction, frequency: np.ndarray, speed: float) -> _Panels:
    """Return the first panels of all frequencies.

    Edges are the tables' slownesses as a moving load sees them, powers of two from there to the largest β,
    and those of the tail.
    """
    largest = rail.reach
    block_of = blocks.nearest_block(frequency, rail.blocks)
    tail = largest * _TAIL_RATIO ** np.arange(1, _TAIL_PANELS + 1)
    halves = largest * 0.5 ** np.arange(1, int(np.log2(largest / _NARROWEST)) + 1)
    first = []
    for block in np.unique(block_of):
        nodes = rail.blocks[int(block)].nodes
        travelling = nodes.edge[(nodes.edge > 0.0) & (nodes.edge <= 1.0)]
        slowness = travelling[::-_EDGE_STRIDE] * nodes.top_slowness
        omega = 2.0 * np.pi * frequency[block_of == block][:, None]
        ahead = omega * slowness / (1.0 + slowness * speed)
        reach = np.maximum(omega * slowness[0], _NARROWEST)
        far = np.where(halves > reach, halves, np.inf)
        ends = np.broadcast_to([0.0, largest, *tail], (omega.size, 2 + tail.size))
        parts = [_within(ahead, largest), _within(far, largest), ends]
        if speed > 0.0:
            with np.errstate(divide="ignore", invalid="ignore"):
                behind = omega * slowness / (slowness * speed - 1.0)
            sign_change = omega / speed
            near = np.where(far < _SIGN_CHANGE_REACH * sign_change, far, np.inf)
            around = behind, -far, sign_change + near, sign_change - near
            parts += [_within(beta, largest) for beta in around]
            parts += [_within(sign_change, tail[-1]), -ends[:, 1:]]
        edge = np.sort(np.concatenate(parts, axis=1), axis=1)
        distinct = np.isfinite(edge)
        distinct[:, 1:] &= edge[:, 1:] > edge[:, :-1] + 1e-9 * largest
        row, edge = np.nonzero(distinct)[0], edge[distinct]
        inner = row[1:] == row[:-1]
        first.append((np.flatnonzero(block_of == block)[row[1:][inner]], edge[:-1][inner], edge[1:][inner]))
    owner, low, high = (np.concatenate(columns) for columns in zip(*first, strict=True))
    return _Panels(owner, 0.5 * (high + low), 0.5 * (high - low))


def _within(value: np.ndarray, limit: float) -> np.ndarray:
    """Return values, with infinity in place of those beyond a limit."""
    return np.where(np.abs(value) < limit, value, np.inf)
