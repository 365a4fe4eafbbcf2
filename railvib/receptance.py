"""Receptances of the rail under standing and moving loads.

    σ_R(d, ω; v) = (1/2π) ∫ H̃_R(β, ω − βv) e^{iβd} dβ

in the frame that moves with the load, d ahead of it. The integrand is tabulated (`railvib.transfer`); the
integral runs over panels between the slownesses at which waves travel, Doppler-shifted, with the place where
ω − βv changes sign (and with it the damping) as a panel's edge. Beyond the tables the rail on its pads
carries the load alone, and the panels go on in powers of two until nothing is left.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numba
import numpy as np
import numpy.typing as npt

from railvib import blocks, cost
from railvib.panels import ORDER, fourier_integrals, nodes_between, unresolved
from railvib.tabulation import largest_wavenumber
from railvib.track import Track, track_response
from railvib.transfer import TransferFunction

_TAIL_PANELS = 10
_MOST_HALVINGS = 12
_MOST_LEVELS = 6
_CHECKS = 5
_EDGES_TAKEN = 3
_RESOLVED = 1e-2
"""Last Legendre coefficients of a panel times its width, over tolerance times peak: the error left is below
1e-2 of the tolerance.
"""


@dataclass(frozen=True)
class ReceptanceBlock:
    """Receptances of the rail over one block at one speed."""

    frequency: np.ndarray = field(
        metadata={"dims": ("frequency",), "unit": "Hz", "description": "frequency of the load"}
    )
    distance: np.ndarray = field(
        metadata={"dims": ("distance",), "unit": "m", "description": "distance ahead of the load"}
    )
    receptance: np.ndarray = field(
        metadata={
            "dims": ("frequency", "distance"),
            "unit": "m/N",
            "description": "displacement of the rail per load",
        }
    )
    block: int
    """Index of the block, see `railvib.blocks`."""
    level: int
    speed: float
    """Speed of the load, m/s."""
    interpolation_error: float
    """Largest error of interpolation half-way between frequencies, relative to the receptance at the load."""


def receptance_block(
    rail: TransferFunction,
    track: Track,
    speed: float,
    distances: npt.ArrayLike,
    block: int,
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> ReceptanceBlock:
    """Tabulate receptances over one block of frequencies, at the first level that passes a check half-way.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `highest_tabulated_frequency` of the block's upper edge
        and halo.
    track, speed, distances
        As in `receptances`.
    block
        Index of the block, see `railvib.blocks`.
    tolerance
        Error allowed, relative to the receptance at the load.
    refinement
        For studies of convergence: 2 halves the steps in frequency that the tolerance asks for.
    """
    beyond = int(np.log2(refinement))
    passed = None
    d = np.unique(np.asarray(distances, float))
    known: dict[float, np.ndarray] = {}

    def rows(level: int, ks: np.ndarray) -> np.ndarray:
        frequency = blocks.frequency(level, ks)
        new = np.array([f for f in frequency if round(f, 9) not in known])
        if new.size:
            computed = receptances(rail, track, speed, np.append(d, 0.0), new, tolerance)
            known.update({round(float(f), 9): row for f, row in zip(new, computed, strict=True)})
        return np.array([known[round(float(f), 9)] for f in frequency])

    for level in range(_MOST_LEVELS + beyond + 1):
        tabulated = rows(level, blocks.indices(block, level))
        halfway = blocks.halfway(block, level, _CHECKS)
        direct = rows(level + 1, halfway)
        interpolated = blocks.interpolated(block, level, blocks.frequency(level + 1, halfway), tabulated)
        error = float((np.abs(interpolated - direct) / np.abs(direct[:, -1:])).max())
        if passed is None and (error <= 0.1 * tolerance or level == _MOST_LEVELS):
            passed = level
        if passed is not None and level >= passed + beyond:
            break
    frequency = blocks.frequency(level, blocks.indices(block, level))
    return ReceptanceBlock(
        frequency=frequency,
        distance=d,
        receptance=np.ascontiguousarray(tabulated[:, :-1]),
        block=block,
        level=level,
        speed=speed,
        interpolation_error=error,
    )


class Receptances:
    """The rail's receptances at one speed over all their blocks."""

    def __init__(self, table: Iterable[ReceptanceBlock]) -> None:
        self.blocks = {each.block: each for each in sorted(table, key=lambda each: each.block)}
        self.distance = next(iter(self.blocks.values())).distance

    def at(self, frequency: np.ndarray) -> np.ndarray:
        """Interpolate to frequencies (n,) in Hz; below the tables the static limit; (n, distances), m/N."""
        which = blocks.assigned(frequency, self.blocks)
        value = np.empty((frequency.size, self.distance.size), complex)
        for block in np.unique(which):
            here = which == block
            table = self.blocks[int(block)]
            f = np.maximum(frequency[here], blocks.edges(table.block)[0])
            value[here] = blocks.interpolated(table.block, table.level, f, table.receptance)
        return value


def highest_tabulated_frequency(
    track: Track, maximum_frequency: float, speed: float, refinement: int = 1
) -> float:
    """Return up to which frequency the rail must be tabulated for receptances up to another one, Hz."""
    return maximum_frequency + largest_wavenumber(track, refinement) * abs(speed) / (2.0 * np.pi)


def receptances(
    rail: TransferFunction,
    track: Track,
    speed: float,
    distances: npt.ArrayLike,
    frequency: npt.ArrayLike,
    tolerance: float = 1e-4,
) -> np.ndarray:
    """Return the rail's receptances ahead of and behind a load.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `highest_tabulated_frequency`.
    track
        The track that it was tabulated for.
    speed
        Speed of the load, m/s, not negative; 0 for a standing load.
    distances
        Signed distances ahead of the load, m, (m,).
    frequency
        Frequencies of the load, Hz, (n,), not negative.
    tolerance
        Relative error allowed.

    Returns
    -------
    ndarray of complex, shape (n, m)
        m/N.

    Notes
    -----
    Eq. 14 and 19 of the paper; CONVENTIONS section 3.
    """
    f = np.atleast_1d(np.asarray(frequency, float))
    d = np.atleast_1d(np.asarray(distances, float))
    away = np.unique(np.abs(d))
    with cost.stage("receptances") as spent:
        panels = _standing_panels(rail, f) if speed == 0.0 else _moving_panels(rail, f, speed, tolerance)
        largest = np.full(f.size, rail.reach)
        np.maximum.at(largest, panels[0], panels[2])
        tail = _tail_panels(track, f, speed, largest)
        owner, low, high, value = (np.concatenate(each) for each in zip(panels, tail, strict=True))
        order = np.argsort(owner, kind="stable")
        first = np.searchsorted(owner[order], np.arange(f.size + 1))
        parts = np.stack([value.real, value.imag])[:, order]
        cosine, sine = _per_frequency(
            first, 0.5 * (low + high)[order], 0.5 * (high - low)[order], parts, away
        )
        spent.evaluations += value.size
        spent.kernel_calls += 1
    column = np.searchsorted(away, np.abs(d))
    even = (cosine[:, 0] + 1j * cosine[:, 1])[:, column]
    odd = (sine[:, 0] + 1j * sine[:, 1])[:, column] * np.sign(d) if speed != 0.0 else 0.0
    return np.asarray((even + 1j * odd) / (2.0 * np.pi))


Panels = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Row of a panel's frequency, its lower and upper edge in rad/m, the response at its nodes."""


def _standing_panels(rail: TransferFunction, frequency: np.ndarray) -> Panels:
    """Return the tables' own panels; the response is even in β, so those over β > 0 count twice."""
    parts = []
    which = blocks.assigned(frequency, rail.blocks)
    for block in np.unique(which):
        rows = np.flatnonzero(which == block)
        table = rail.blocks[int(block)]
        f = np.maximum(frequency[rows], rail.lowest)
        edge = table.nodes.panel_edges(f)
        _beta, transfer = rail.at(int(block), f)
        value = 2.0 * transfer.reshape(rows.size, -1, ORDER)
        owner = np.repeat(rows, edge.shape[1] - 1)
        parts.append((owner, edge[:, :-1].ravel(), edge[:, 1:].ravel(), value.reshape(-1, ORDER)))
    owner, low, high, value = (np.concatenate(each) for each in zip(*parts, strict=True))
    return owner, low, high, value


def _moving_panels(rail: TransferFunction, frequency: np.ndarray, speed: float, tolerance: float) -> Panels:
    """Return panels over all β up to the largest, halved until the response is resolved.

    They begin with every third edge of the table, whose panels resolve the ground at some distance as well.
    """
    largest = rail.reach
    edges = []
    which = blocks.assigned(frequency, rail.blocks)
    for f, block in zip(frequency, which, strict=True):
        table = rail.blocks[int(block)]
        slowness = table.edge[(table.edge > 0.0) & (table.edge <= 1.0)] * table.top_slowness
        edge = np.sort(_edges(slowness[::-_EDGES_TAKEN], 2.0 * np.pi * f, speed, largest))
        edge = edge[np.abs(edge) <= largest]
        edges.append(edge[np.diff(edge, prepend=-np.inf) > 1e-9 * largest])
    owner = np.repeat(np.arange(frequency.size), [each.size - 1 for each in edges])
    low = np.concatenate([each[:-1] for each in edges])
    high = np.concatenate([each[1:] for each in edges])
    peak = np.zeros(frequency.size)
    parts: list[Panels] = []
    for halving in range(_MOST_HALVINGS + 1):
        beta = nodes_between(np.stack([low, high], axis=1))
        seen = 2.0 * np.pi * frequency[owner][:, None] - beta * speed
        value = rail.response(beta.ravel(), seen.ravel()).reshape(beta.shape)
        np.maximum.at(peak, owner, np.abs(value).max(axis=1))
        bad = unresolved(value)[:, 0] * (high - low) > _RESOLVED * tolerance * peak[owner]
        bad &= halving < _MOST_HALVINGS
        parts.append((owner[~bad], low[~bad], high[~bad], value[~bad]))
        if not bad.any():
            break
        middle = 0.5 * (low + high)[bad]
        owner = np.concatenate([owner[bad], owner[bad]])
        low, high = np.concatenate([low[bad], middle]), np.concatenate([middle, high[bad]])
    return tuple(np.concatenate(each) for each in zip(*parts, strict=True))  # type: ignore[return-value]


@numba.njit(cache=True, error_model="numpy")
def _edges(slowness, omega, speed, largest):
    """Return edges in no order: the tables' slownesses as a moving load sees them, and powers of two."""
    reach = 1e-2
    for each in slowness:
        reach = max(reach, omega * each)
    octaves = max(int(np.log2(largest / reach)), 1) if reach < largest else 0
    turn = omega / speed
    edge = np.empty(2 * slowness.size + 4 * (octaves + 1) + 4)
    # One by one: Numba takes seconds to compile assignments to slices.
    edge[0], edge[1], edge[2], edge[3] = -largest, 0.0, largest, turn
    n = 4
    for each in slowness:
        edge[n] = omega * each / (1.0 + each * speed)
        n += 1
        ahead = 1.0 - each * speed
        if abs(ahead) > 1e-9:
            edge[n] = -omega * each / ahead
            n += 1
    for octave in range(octaves + 1):
        far = reach * (largest / reach) ** (octave / octaves) if octaves > 0 else largest
        edge[n], edge[n + 1], edge[n + 2], edge[n + 3] = far, -far, turn + far, turn - far
        n += 4
    return edge[:n]


def _tail_panels(track: Track, frequency: np.ndarray, speed: float, largest: np.ndarray) -> Panels:
    """Return panels beyond the largest tabulated wavenumbers, on both sides; the ground no longer yields."""
    owner, low, high = [], [], []
    for row, f in enumerate(frequency):
        ends = largest[row] * 2.0 ** np.arange(_TAIL_PANELS + 1)
        turn = 2.0 * np.pi * f / speed if speed > 0.0 else 0.0
        if ends[0] < turn < ends[-1]:
            ends = np.sort(np.append(ends, turn))
        low.append(np.concatenate([-ends[:0:-1], ends[:-1]]))
        high.append(np.concatenate([-ends[-2::-1], ends[1:]]))
        owner.append(np.full(low[-1].size, row))
    rows, lows, highs = np.concatenate(owner), np.concatenate(low), np.concatenate(high)
    beta = nodes_between(np.stack([lows, highs], axis=1))
    value, _force = track_response(track, beta, 2.0 * np.pi * frequency[rows][:, None] - beta * speed, 0.0)
    return rows, lows, highs, value


@numba.njit(cache=True, error_model="numpy")
def _per_frequency(first, centre, half, value, distance):
    """Return the cosine and sine integrals of every frequency's panels, (frequencies, 2, distances) each."""
    cosine = np.zeros((first.shape[0] - 1, 2, distance.shape[0]))
    sine = np.zeros((first.shape[0] - 1, 2, distance.shape[0]))
    for i in range(first.shape[0] - 1):
        own = slice(first[i], first[i + 1])
        fourier_integrals(centre[own], half[own], value[:, own], distance, cosine[i], sine[i])
    return cosine, sine
