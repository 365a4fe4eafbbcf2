"""Receptances of the rail under standing and moving loads.

    σ_R(d, ω; v) = (1/2π) ∫ H̃_R(β, ω − βv) e^{iβd} dβ

in the frame that moves with the load, d ahead of it. The integrand is tabulated (`railvib.transfer`), and
integrated by `railvib.rail_integrals`; the receptances are tabulated in turn, over frequency.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from railvib import blocks, cost
from railvib.rail_integrals import rail_integrals
from railvib.tabulation import largest_wavenumber
from railvib.track import Track
from railvib.transfer import TransferFunction

_MOST_LEVELS = 6
_CHECKS = 5


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


def receptance_blocks(
    rail: TransferFunction,
    track: Track,
    speed: float,
    distances: npt.ArrayLike,
    which: Iterable[int],
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> Iterator[ReceptanceBlock]:
    """Tabulate receptances over blocks of frequencies, each at the first level that passes a check half-way.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `highest_tabulated_frequency` of the highest block's
        upper edge and halo.
    track, speed, distances
        As in `receptances`.
    which
        Indices of the blocks, see `railvib.blocks`. No block depends on the others: what it has in common
        with their halos is computed once.
    tolerance
        Error allowed, relative to the receptance at the load.
    refinement
        For studies of convergence: 2 halves the steps in frequency that the tolerance asks for.
    """
    d = np.unique(np.asarray(distances, float))
    known: dict[float, np.ndarray] = {}

    def rows(*places: tuple[int, np.ndarray]) -> list[np.ndarray]:
        """Return receptances at frequencies that are given by their level and indices."""
        at = {
            index / 2.0**level: f
            for level, indices in places
            for index, f in zip(indices.tolist(), blocks.frequency(level, indices).tolist(), strict=True)
        }
        new = [place for place in at if place not in known]
        if new:
            frequency = np.array([at[place] for place in new])
            computed = receptances(rail, track, speed, np.append(d, 0.0), frequency, tolerance)
            known.update(zip(new, computed, strict=True))
        return [np.array([known[index / 2.0**level] for index in indices]) for level, indices in places]

    beyond = int(np.log2(refinement))
    for block in which:
        passed = None
        for level in range(_MOST_LEVELS + beyond + 1):
            indices, halfway = blocks.indices(block, level), blocks.halfway(block, level, _CHECKS)
            tabulated, direct = rows((level, indices), (level + 1, halfway))
            interpolated = blocks.interpolated(block, level, blocks.frequency(level + 1, halfway), tabulated)
            error = float((np.abs(interpolated - direct) / np.abs(direct[:, -1:])).max())
            if passed is None and (error <= 0.1 * tolerance or level == _MOST_LEVELS):
                passed = level
            if passed is not None and level >= passed + beyond:
                break
        yield ReceptanceBlock(
            frequency=blocks.frequency(level, indices),
            distance=d,
            receptance=np.ascontiguousarray(tabulated[:, :-1]),
            block=block,
            level=level,
            speed=speed,
            interpolation_error=error,
        )


def receptance_block(
    rail: TransferFunction,
    track: Track,
    speed: float,
    distances: npt.ArrayLike,
    block: int,
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> ReceptanceBlock:
    """Tabulate receptances over one block of frequencies, as `receptance_blocks` does."""
    (made,) = receptance_blocks(rail, track, speed, distances, [block], tolerance, refinement)
    return made


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
        even, odd, number = rail_integrals(rail, track, speed, f, away, tolerance)
        spent.evaluations += number
        spent.kernel_calls += 1
    column = np.searchsorted(away, np.abs(d))
    return np.asarray((even[:, column] + 1j * odd[:, column] * np.sign(d)) / (2.0 * np.pi))
