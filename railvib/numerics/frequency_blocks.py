"""Canonical frequencies: blocks of half a decade, and nested levels of frequencies inside them.

Frequencies are 10^(0.05 + k/(50·2^level)) Hz with integer k: level by level the step halves, and each level
contains the one before. Block i reaches from 10^(0.05 + i/2) to 10^(0.05 + (i+1)/2) Hz, so that the edges at
1.122, 11.22, 112.2 Hz are those of the one-third octaves around 1, 10 and 100 Hz. No study shifts a block's
edges or its frequencies, so blocks are shared.
"""

from collections.abc import Iterable

import numpy as np

PER_DECADE = 2
"""Blocks per decade."""
STEPS = 25
"""Steps of a block at level 0: 4.7 % each."""
HALO = 5
"""Frequencies tabulated beyond each edge, so that interpolation inside a block needs no neighbour."""
LOWEST = -3
"""First block: below its lower edge, 0.0355 Hz, every response is taken as static."""
SHIFT = 0.05
"""Decimal logarithm of the edge of block 0 in Hz."""
_EDGE = 1e-6
"""Part of a block that a frequency may lie beyond its edge, where bands end at it to rounding."""
STENCIL = 2 * HALO
"""Points of the interpolation along frequency."""


def edges(block: int) -> tuple[float, float]:
    """Return the lowest and the highest frequency of a block, Hz."""
    return 10.0 ** (SHIFT + block / PER_DECADE), 10.0 ** (SHIFT + (block + 1) / PER_DECADE)


def up_to(maximum_frequency: float) -> range:
    """Return the blocks from the static limit up to a frequency in Hz."""
    last = int(np.ceil(PER_DECADE * (np.log10(maximum_frequency) - SHIFT) - 1e-9)) - 1
    return range(LOWEST, max(last, LOWEST) + 1)


def indices(block: int, level: int) -> np.ndarray:
    """Return the indices k of a block's frequencies at a level, the halo included."""
    steps = STEPS * 2**level
    return np.arange(block * steps - HALO, (block + 1) * steps + HALO + 1)


def inside(block: int, level: int) -> np.ndarray:
    """Return which of `indices` lie in the block, its lower edge included, and not in the halo."""
    steps = STEPS * 2**level
    k = indices(block, level)
    return np.asarray((k >= block * steps) & (k < (block + 1) * steps))


def frequency(level: int, k: np.ndarray | int) -> np.ndarray:
    """Return 10^(0.05 + k/(50·2^level)), Hz."""
    return np.asarray(10.0 ** (SHIFT + np.asarray(k) / (PER_DECADE * STEPS * 2**level)))


def reach(block: int) -> float:
    """Return the highest frequency that a block may tabulate, the widest halo included, Hz."""
    return float(frequency(0, indices(block, 0)[-1]))


def position(block: int, level: int, f: np.ndarray) -> np.ndarray:
    """Return where frequencies f in Hz lie among a block's, as fractional row numbers."""
    steps = STEPS * 2**level
    return np.asarray((np.log10(f) - SHIFT) * (PER_DECADE * steps) - (block * steps - HALO))


def halfway_indices(block: int, level: int, number: int) -> np.ndarray:
    """Return some indices k of the next level, half-way between frequencies of this one, across the block."""
    finer = indices(block, level + 1)
    inner = finer[(finer % 2 == 1) & (finer > finer[0] + HALO) & (finer < finer[-1] - HALO)]
    return np.asarray(inner[np.linspace(0, inner.size - 1, number).round().astype(int)])


def check_coverage(f: np.ndarray, available: Iterable[int]) -> None:
    """Raise unless frequencies in Hz lie in some of the available blocks, which are neighbours.

    Below the lowest block there is, every response is static.

    Raises
    ------
    ValueError
        If one lies beyond: to extrapolate tables is a fault of whoever chose them.
    """
    if not f.size:
        return
    first, last = min(available), max(available)
    ends = PER_DECADE * (np.log10([max(f.min(), 1e-9), max(f.max(), 1e-9)]) - SHIFT)
    if ends[1] > last + 1 + _EDGE or (ends[0] < first - _EDGE and first > LOWEST):
        raise ValueError(
            f"frequencies from {f.min():.6g} to {f.max():.6g} Hz: tables reach from "
            f"{edges(first)[0]:.6g} to {edges(last)[1]:.6g} Hz"
        )


def nearest_block(f: np.ndarray, available: Iterable[int]) -> np.ndarray:
    """Return the blocks in which frequencies in Hz lie, or the nearest of those available."""
    index = np.floor(PER_DECADE * (np.log10(np.maximum(f, 1e-9)) - SHIFT) + 1e-9)
    return np.asarray(np.clip(index, min(available), max(available)), int)


def between(lower: float, upper: float) -> range:
    """Return the blocks that hold the frequencies from `lower` to `upper`, Hz.

    A band that ends at the edge of a block needs no further block.
    """
    ends = PER_DECADE * (np.log10([lower, upper]) - SHIFT)
    return range(max(int(np.floor(ends[0] + _EDGE)), LOWEST), max(int(np.ceil(ends[1] - _EDGE)), LOWEST + 1))
