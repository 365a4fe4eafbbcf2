"""Fourier integrals over wavenumber of the rail's response to loads that stand or move.

    ∫ H̃_R(β, ω − βv) e^{iβd} dβ

The integral runs over panels between the slownesses at which waves travel, Doppler-shifted, with the place
where ω − βv changes sign (and with it the damping) as a panel's edge. A panel that does not resolve the
response is halved. Beyond the tables the rail on its pads carries the load alone.
"""

import numba
import numpy as np

from railvib import blocks
from railvib.panels import NODE, ORDER, TO_LEGENDRE, fourier_integrals
from railvib.scattered import ROOM, interpolate
from railvib.track import Track, load, parameters
from railvib.transfer import TransferFunction
from railvib.vector_math import LANES, reciprocal

_TAIL_PANELS = 3
_TAIL_RATIO = 4.0
"""Each panel of the tail ends at so many times its beginning. The tail is less than 1e-3 of all and falls
with the cube of where it begins: what is cut off is below 1e-8.
"""
_MOST_HALVINGS = 12
_EDGES_TAKEN = 3
_NARROWEST = 0.01
"""Width of the narrowest panels in powers of two, rad/m, where no wave asks for narrower ones."""
_TURN_SEEN = 4.0
"""Panels need no edge for ω − βv = 0 at distances from it of so many times its β: it is as far as β = 0."""
_RESOLVED = 1e-2
"""Last Legendre coefficients of a panel times its width, over tolerance times peak: the error left is below
1e-2 of the tolerance.
"""
_AT_ONCE = LANES // ORDER


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
        As in `railvib.receptance.receptances`.
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
        At how many wavenumbers the response was computed.

    Raises
    ------
    ValueError
        If a frequency that the track sees lies above the tables.
    """
    highest = float(frequency.max(initial=0.0)) + rail.reach * speed / (2.0 * np.pi)
    if speed > 0.0 and highest > rail.highest * (1.0 + 1e-9):  # standing, the halo of a table is enough
        raise ValueError(f"frequency {highest:g} Hz lies above the tabulated {rail.highest:g} Hz")
    if speed == 0.0:  # below the tables the static limit
        frequency = np.maximum(frequency, rail.lowest)
    edge, count = _edges(rail, frequency, speed)
    # The response to a standing load is even in β: its panels lie over β > 0 and count twice.
    sides = 2.0 if speed == 0.0 else 1.0
    cosine = np.zeros((frequency.size, 2, distance.size))
    sine = np.zeros((frequency.size, 2, distance.size))
    number = _integrals(
        rail.direct if rail.under_track is None else rail.under_track,
        rail.under_track is not None,
        parameters(track),
        (rail.lowest, rail.reach, speed, _RESOLVED * tolerance),
        frequency,
        edge,
        count,
        distance,
        cosine,
        sine,
    )
    even = sides * (cosine[:, 0] + 1j * cosine[:, 1])
    odd = sine[:, 0] + 1j * sine[:, 1] if speed != 0.0 else np.zeros_like(even)
    return even, odd, number


def _edges(rail: TransferFunction, frequency: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges of the first panels, (n, edges), ascending, and how many of them count.

    They are the tables' slownesses as a moving load sees them, powers of two from there to the largest β, and
    the tail's. Of the tables' edges every third is taken: their panels resolve the ground at some distance as
    well.
    """
    largest = rail.reach
    which = blocks.assigned(frequency, rail.blocks)
    tail = largest * _TAIL_RATIO ** np.arange(1, _TAIL_PANELS + 1)
    halves = largest * 0.5 ** np.arange(1, int(np.log2(largest / _NARROWEST)) + 1)
    found = []
    for block in np.unique(which):
        table = rail.blocks[int(block)]
        slowness = table.edge[(table.edge > 0.0) & (table.edge <= 1.0)][::-_EDGES_TAKEN] * table.top_slowness
        omega = 2.0 * np.pi * frequency[which == block][:, None]
        ahead = omega * slowness / (1.0 + slowness * speed)
        reach = np.maximum(omega * slowness[0], _NARROWEST)
        far = np.where(halves > reach, halves, np.inf)
        ends = np.broadcast_to([0.0, largest, *tail], (omega.size, 2 + tail.size))
        parts = [_within(ahead, largest), _within(far, largest), ends]
        if speed > 0.0:
            with np.errstate(divide="ignore", invalid="ignore"):
                behind = omega * slowness / (slowness * speed - 1.0)
            turn = omega / speed
            near = np.where(far < _TURN_SEEN * turn, far, np.inf)
            parts += [_within(each, largest) for each in (behind, -far, turn + near, turn - near)]
            parts += [_within(turn, tail[-1]), -ends[:, 1:]]
        found.append((which == block, _distinct(np.concatenate(parts, axis=1), 1e-9 * largest)))
    edge = np.full((frequency.size, max(each.shape[1] for _, each in found)), np.inf)
    for rows, each in found:
        edge[rows, : each.shape[1]] = each
    return edge, np.isfinite(edge).sum(axis=1)


def _within(value: np.ndarray, limit: float) -> np.ndarray:
    """Return values, infinite in place of those that are not inside a limit."""
    return np.where(np.abs(value) < limit, value, np.inf)


def _distinct(value: np.ndarray, least: float) -> np.ndarray:
    """Return rows of values ascending, infinite in place of those nearer than `least` to the one before."""
    ascending = np.sort(value, axis=1)
    with np.errstate(invalid="ignore"):
        ascending[:, 1:][np.diff(ascending, axis=1) <= least] = np.inf
    return np.sort(ascending, axis=1)


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _integrals(tables, on_ground, track, limits, frequency, edge, count, distance, cosine, sine):
    """Add the integrals of every frequency to `cosine` and `sine`; return the number of wavenumbers."""
    bound = limits[3]
    room = np.empty((ROOM, LANES))
    whole = np.empty((2, LANES), np.int64)
    loaded = np.empty(6 * LANES)
    sign = np.empty(LANES)
    most = edge.shape[1] + 2 * _AT_ONCE * _MOST_HALVINGS
    low = np.empty(most)
    high = np.empty(most)
    left = np.empty(most, np.int64)
    centre = np.empty(edge.shape[1])
    half = np.empty(edge.shape[1])
    value = np.empty((2, edge.shape[1], ORDER))
    number = 0
    for i in range(frequency.shape[0]):
        omega = 2.0 * np.pi * frequency[i]
        panels = count[i] - 1
        for p in range(panels):
            centre[p] = 0.5 * (edge[i, p + 1] + edge[i, p])
            half[p] = 0.5 * (edge[i, p + 1] - edge[i, p])
        _respond(
            panels, centre, half, omega, tables, on_ground, track, limits, room, whole, loaded, sign, value
        )
        number += panels
        peak = _peak(panels, value)
        pending = 0
        halvings = _MOST_HALVINGS
        while True:
            resolved = 0
            for p in range(panels):
                if halvings > 0 and _unresolved(value, p) * 4.0 * half[p] * half[p] > bound * bound * peak:
                    # Both halves, one after the other: what depends on the width alone then serves both.
                    for side in range(2):
                        low[pending] = centre[p] - (1 - side) * half[p]
                        high[pending] = centre[p] + side * half[p]
                        left[pending] = halvings - 1
                        pending += 1
                else:
                    centre[resolved] = centre[p]
                    half[resolved] = half[p]
                    for q in range(2):
                        for j in range(ORDER):
                            value[q, resolved, j] = value[q, p, j]
                    resolved += 1
            fourier_integrals(
                centre[:resolved], half[:resolved], value[:, :resolved], distance, cosine[i], sine[i]
            )
            if pending == 0:
                break
            panels = 0
            halvings = left[pending - 1]
            while pending > 0 and panels < _AT_ONCE and left[pending - 1] == halvings:
                pending -= 1
                centre[panels] = 0.5 * (high[pending] + low[pending])
                half[panels] = 0.5 * (high[pending] - low[pending])
                panels += 1
            _respond(
                panels,
                centre,
                half,
                omega,
                tables,
                on_ground,
                track,
                limits,
                room,
                whole,
                loaded,
                sign,
                value,
            )
            number += panels
    return number * ORDER


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _respond(panels, centre, half, omega, tables, on_ground, track, limits, room, whole, loaded, sign, value):
    """Write the response at the nodes of panels, (2, panels, order), real and imaginary parts."""
    bed, support, pad, rail = track
    lowest, reach, speed, _ = limits
    nodes = panels * ORDER
    for first in range(0, nodes, LANES):
        for i in range(LANES):
            node = min(first + i, nodes - 1)
            p = node // ORDER
            beta = centre[p] + half[p] * NODE[node - p * ORDER]
            seen = omega - beta * speed
            room[0, i] = max(abs(seen) / (2.0 * np.pi), lowest)
            room[1, i] = min(abs(beta), reach)
            loaded[4 * LANES + i] = abs(beta)
            loaded[5 * LANES + i] = 2.0 * np.pi * room[0, i]
            sign[i] = -1.0 if seen < 0.0 else 1.0
        interpolate(tables, room, whole)
        for i in range(LANES):
            yields = on_ground and loaded[4 * LANES + i] <= reach
            loaded[i] = room[2, i] if yields else 0.0
            loaded[LANES + i] = room[3, i] if yields else 0.0
        load(LANES, loaded, bed, support, pad, rail)
        for i in range(LANES):
            force = complex(loaded[2 * LANES + i], loaded[3 * LANES + i])
            response = complex(loaded[i], loaded[LANES + i]) * reciprocal(force)
            loaded[i] = response.real
            loaded[LANES + i] = response.imag
        if not on_ground:
            for i in range(LANES):
                if loaded[4 * LANES + i] <= reach:
                    loaded[i] = room[2, i]
                    loaded[LANES + i] = room[3, i]
        for i in range(min(LANES, nodes - first)):
            p = (first + i) // ORDER
            value[0, p, first + i - p * ORDER] = loaded[i]
            value[1, p, first + i - p * ORDER] = sign[i] * loaded[LANES + i]


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _peak(panels, value):
    """Return the largest squared size of values (2, panels, order)."""
    peak = 0.0
    for p in range(panels):
        for j in range(ORDER):
            peak = max(peak, value[0, p, j] * value[0, p, j] + value[1, p, j] * value[1, p, j])
    return peak


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _unresolved(value, p):
    """Return the squared size of a panel's last Legendre coefficients."""
    size = 0.0
    for n in range(ORDER - 2, ORDER):
        real = 0.0
        imag = 0.0
        for j in range(ORDER):
            real += TO_LEGENDRE[n, j] * value[0, p, j]
            imag += TO_LEGENDRE[n, j] * value[1, p, j]
        size = max(size, real * real + imag * imag)
    return size
