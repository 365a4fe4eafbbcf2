"""Receptances of the rail under standing and moving loads.

    σ_R(d, ω; v) = (1/2π) ∫ H̃_R(β, ω − βv) e^{iβd} dβ

in the frame that moves with the load, d ahead of it. The integrand is tabulated (`railvib.transfer.table`)
and integrated by `railvib.forces.rail_integrals`; the receptances are tabulated in turn, over frequency.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from railvib import cost
from railvib.forces.rail_integrals import rail_integrals
from railvib.forces.smooth_receptance import Load, Reduced, remove_fast_phases
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_interpolation import interpolate, interpolate_blocks
from railvib.numerics.refinement import search_level, search_levels
from railvib.parameters.track import Track
from railvib.transfer.transfer_function import TransferFunction

_CHECKS = 9
"""Places between the frequencies of a level at which interpolation without fast phases is checked."""
_STORED_CHECKS = 25
"""Places between stored frequencies at which interpolation with and without fast phases is compared."""
_STORED_SHARE, _DIRECT_SHARE = 0.1, 0.07
"""Shares of the tolerance that all interpolation may take, and interpolation without fast phases."""


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
        return interpolate_blocks(self.block, self.level, above, self.receptance)


def tabulate_receptances(
    rail: TransferFunction,
    track: Track,
    speed: float,
    distances: npt.ArrayLike,
    block_range: Iterable[int],
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> Receptances:
    """Tabulate receptances over blocks of frequencies, each at the first level that passes a check half-way.

    They are computed at frequencies between which they can be interpolated once their fast phases are taken
    out (`railvib.forces.smooth_receptance`), and stored at frequencies so close to each other that they can
    be interpolated as they are.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `highest_tabulated_frequency` (in
        `railvib.transfer.highest_frequencies`) of the highest block's
        upper edge and halo.
    track, speed, distances
        As in `receptances`.
    block_range
        Indices of the blocks, ascending, see `railvib.numerics.frequency_blocks`. No block depends on the
        others; frequencies in the halos of several blocks are computed once.
    tolerance
        Error allowed, relative to the receptance at the load.
    refinement
        For studies of convergence: 2 halves the steps in frequency that the tolerance asks for.
    """
    d = np.unique(np.asarray(distances, float))
    samples = _Samples(Load(rail, track, speed, np.append(d, 0.0)), tolerance)
    beyond = int(np.log2(refinement))
    tables: dict[int, _Block] = {}
    for resolved in search_levels(dict.fromkeys(block_range, 0), samples.tabulate, beyond=beyond):
        for block, (level, (reduced, error)) in resolved.items():
            tables[block] = _stored(
                reduced, samples.tabulated(block, level), error, tolerance, level + beyond
            )
    ordered = [tables[block] for block in sorted(tables)]
    return Receptances(
        frequency=np.concatenate([table.frequency for table in ordered]),
        distance=d,
        receptance=np.concatenate([table.receptance[:, :-1] for table in ordered]),
        block=np.array([table.block for table in ordered]),
        level=np.array([table.level for table in ordered]),
        interpolation_error=np.array([table.error for table in ordered]),
        speed=speed,
        inside=np.concatenate([blocks.inside(table.block, table.level) for table in ordered]),
    )


class _Samples:
    """Receptances at canonical frequencies, each computed once.

    Blocks are taken together, level by level: a few wavenumbers take as long as many.
    """

    def __init__(self, load: Load, tolerance: float) -> None:
        self._load = load
        self._tolerance = tolerance
        self._known: dict[float, np.ndarray] = {}

    def tabulate(
        self, level: int, pending: Sequence[int]
    ) -> Callable[[int, bool], tuple[tuple[Reduced, float], bool]]:
        """Compute receptances at a level and half-way, and return the check of a block."""
        good_enough = _DIRECT_SHARE * self._tolerance
        halfway = {block: blocks.halfway_indices(block, level, _CHECKS) for block in pending}
        self._compute(
            *((level, blocks.indices(block, level)) for block in pending),
            *((level + 1, places) for places in halfway.values()),
        )

        def check(block: int, _required: bool) -> tuple[tuple[Reduced, float], bool]:
            between = blocks.frequency(level + 1, halfway[block])
            direct = self._at(level + 1, halfway[block])
            reduced, error = remove_fast_phases(
                self._load, block, level, self.tabulated(block, level), between, direct, good_enough
            )
            return (reduced, error), error <= good_enough

        return check

    def tabulated(self, block: int, level: int) -> np.ndarray:
        """Return the receptances at the frequencies of a block and level, (frequencies, distances)."""
        return self._at(level, blocks.indices(block, level))

    def _compute(self, *places: tuple[int, np.ndarray]) -> None:
        """Compute what is missing at frequencies that are given by their level and indices."""
        frequency = {
            index / 2.0**level: f
            for level, indices in places
            for index, f in zip(indices.tolist(), blocks.frequency(level, indices).tolist(), strict=True)
        }
        missing = [place for place in frequency if place not in self._known]
        if missing:
            load = self._load
            at = np.array([frequency[place] for place in missing])
            values = receptances(load.rail, load.track, load.speed, load.distance, at, self._tolerance)
            self._known.update(zip(missing, values, strict=True))

    def _at(self, level: int, indices: np.ndarray) -> np.ndarray:
        return np.array([self._known[index / 2.0**level] for index in indices.tolist()])


class _Block(NamedTuple):
    """The rows of `Receptances` for one block, with the receptance at the load as the last column."""

    block: int
    level: int
    error: float
    frequency: np.ndarray
    receptance: np.ndarray


def _stored(reduced: Reduced, tabulated: np.ndarray, error: float, tolerance: float, least: int) -> _Block:
    """Return the block to be stored, at frequencies so close that no phase need be taken out."""
    block = reduced.block

    def check(level: int, _required: bool) -> tuple[_Block, bool]:
        frequency = blocks.frequency(level, blocks.indices(block, level))
        receptance = tabulated if level == reduced.level else reduced.at(frequency)
        between = blocks.frequency(level + 1, blocks.halfway_indices(block, level, _STORED_CHECKS))
        interpolated = interpolate(block, level, between, receptance)
        further = _largest_error(interpolated, reduced.at(between))
        table = _Block(block, level, error + further, frequency, receptance)
        return table, further <= (_STORED_SHARE - _DIRECT_SHARE) * tolerance

    _level, table = search_level(least, check)
    return table


def _largest_error(value: np.ndarray, exact: np.ndarray) -> float:
    """Return the largest error, relative to the receptance at the load, the last column."""
    return float((np.abs(value - exact) / np.abs(exact[:, -1:])).max())


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
        The rail's tabulated transfer function, up to
        `railvib.transfer.highest_frequencies.highest_tabulated_frequency`.
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
    Eq. 14 and 19 of the paper; docs/conventions.md, ground and track.
    """
    f = np.atleast_1d(np.asarray(frequency, float))
    d = np.atleast_1d(np.asarray(distances, float))
    distinct = np.unique(np.abs(d))
    with cost.stage("receptances") as spent:
        even, odd, number = rail_integrals(rail, track, speed, f, distinct, tolerance)
        spent.evaluations += number
        spent.kernel_calls += 1
    column = np.searchsorted(distinct, np.abs(d))
    return np.asarray((even[:, column] + 1j * odd[:, column] * np.sign(d)) / (2.0 * np.pi))
