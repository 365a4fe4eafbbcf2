"""Receptances of the rail under standing and moving loads.

    σ_R(d, ω; v) = (1/2π) ∫ H̃_R(β, ω − βv) e^{iβd} dβ

in the frame that moves with the load, d ahead of it. The integrand is tabulated (`railvib.transfer.table`),
and integrated by `railvib.forces.rail_integrals`; the receptances are tabulated in turn, over frequency.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from railvib import cost
from railvib.forces.rail_integrals import rail_integrals
from railvib.forces.smooth_receptance import Load, Reduced, smoothest
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.track import Track
from railvib.transfer.nodes import largest_wavenumber
from railvib.transfer.transfer_function import TransferFunction

_MOST_LEVELS = 6
_CHECKS = 9
_STORED_CHECKS = 25
"""Half-way between stored frequencies, where interpolation with and without fast phases is compared."""
_DIRECT_SHARE = 0.07
"""Of the tolerance, what interpolation without fast phases may take: of 0.1 for all."""


@dataclass(frozen=True)
class Receptances:
    """The rail's receptances at one speed, block after block of frequencies."""

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
    block: np.ndarray = field(metadata={"dims": ("block",), "unit": "", "description": "index of the block"})
    level: np.ndarray = field(
        metadata={"dims": ("block",), "unit": "", "description": "level of the block's frequencies"}
    )
    interpolation_error: np.ndarray = field(
        metadata={
            "dims": ("block",),
            "unit": "1",
            "description": "largest error half-way between frequencies over the receptance at the load",
        }
    )
    speed: float
    """Speed of the load, m/s."""
    inside: np.ndarray | None = field(
        default=None,
        metadata={
            "dims": ("frequency",),
            "unit": "",
            "description": "whether the frequency lies in its block, not in the halo; not in older stores",
        },
    )

    def at(self, frequency: np.ndarray) -> np.ndarray:
        """Interpolate to frequencies (n,) in Hz; below the tables the static limit; (n, distances), m/N."""
        above = np.maximum(frequency, blocks.edges(int(self.block.min()))[0])
        return blocks.across(self.block, self.level, above, self.receptance)


def tabulated_receptances(
    rail: TransferFunction,
    track: Track,
    speed: float,
    distances: npt.ArrayLike,
    which: Iterable[int],
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> Receptances:
    """Tabulate receptances over blocks of frequencies, each at the first level that passes a check half-way.

    They are computed where they determine what does not turn fast with frequency
    (`railvib.forces.smooth_receptance`), and stored at frequencies so near each other that they can be
    interpolated as they are.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `highest_tabulated_frequency` of the highest block's
        upper edge and halo.
    track, speed, distances
        As in `receptances`.
    which
        Indices of the blocks, ascending, see `railvib.numerics.frequency_blocks`. No block depends on the
        others: what it has in common with their halos is computed once.
    tolerance
        Error allowed, relative to the receptance at the load.
    refinement
        For studies of convergence: 2 halves the steps in frequency that the tolerance asks for.
    """
    d = np.unique(np.asarray(distances, float))
    load = Load(rail, track, speed, np.append(d, 0.0))
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
            computed = receptances(rail, track, speed, load.distance, frequency, tolerance)
            known.update(zip(new, computed, strict=True))
        return [np.array([known[index / 2.0**level] for index in indices]) for level, indices in places]

    beyond = int(np.log2(refinement))
    ordered = pending = list(which)
    passed: dict[int, int] = {}
    found: dict[int, _Block] = {}
    # Level by level, all blocks that need it together: a few wavenumbers take as long as many.
    for level in range(_MOST_LEVELS + beyond + 1):
        halfway = [blocks.halfway(block, level, _CHECKS) for block in pending]
        own = [blocks.indices(block, level) for block in pending]
        computed = rows(*((level, each) for each in own), *((level + 1, each) for each in halfway))
        waiting = []
        for i, block in enumerate(pending):
            tabulated, direct = computed[i], computed[len(pending) + i]
            between = blocks.frequency(level + 1, halfway[i])
            enough = _DIRECT_SHARE * tolerance
            reduced, error = smoothest(load, block, level, tabulated, between, direct, enough)
            if error <= enough or level >= _MOST_LEVELS:
                passed.setdefault(block, level)
            if block in passed and level >= passed[block] + beyond:
                found[block] = _stored(reduced, tabulated, error, tolerance, level + beyond)
            else:
                waiting.append(block)
        pending = waiting
        if not pending:
            break
    made = [found[block] for block in ordered]
    return Receptances(
        frequency=np.concatenate([each.frequency for each in made]),
        distance=d,
        receptance=np.concatenate([each.receptance[:, :-1] for each in made]),
        block=np.array([each.block for each in made]),
        level=np.array([each.level for each in made]),
        interpolation_error=np.array([each.error for each in made]),
        speed=speed,
        inside=np.concatenate([blocks.inside(each.block, each.level) for each in made]),
    )


class _Block(NamedTuple):
    """The rows of `Receptances` that belong to one block, and of the receptance at the load in the end."""

    block: int
    level: int
    error: float
    frequency: np.ndarray
    receptance: np.ndarray


def _stored(found: Reduced, tabulated: np.ndarray, error: float, tolerance: float, least: int) -> _Block:
    """Return the block to be stored: at frequencies so near each other that no phase need be taken out."""
    block = found.block
    for level in range(least, max(least, _MOST_LEVELS) + 1):
        frequency = blocks.frequency(level, blocks.indices(block, level))
        receptance = tabulated if level == found.level else found.at(frequency)
        between = blocks.frequency(level + 1, blocks.halfway(block, level, _STORED_CHECKS))
        interpolated = blocks.interpolated(block, level, between, receptance)
        further = _largest_error(interpolated, found.at(between))
        if further <= (0.1 - _DIRECT_SHARE) * tolerance:
            break
    return _Block(block, level, error + further, frequency, receptance)


def _largest_error(value: np.ndarray, exact: np.ndarray) -> float:
    """Return the largest error, relative to the receptance at the load, the last one."""
    return float((np.abs(value - exact) / np.abs(exact[:, -1:])).max())


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
    Eq. 14 and 19 of the paper; docs/conventions.md section 3.
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
