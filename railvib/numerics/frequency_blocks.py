"""Canonical frequencies: blocks of half a decade, and nested levels of frequencies inside them.

Frequencies are 10^(0.05 + k/(50·2^level)) Hz with integer k: level by level the step halves, and each level
contains the one before. Block i reaches from 10^(0.05 + i/2) to 10^(0.05 + (i+1)/2) Hz, so that the edges at
1.122, 11.22, 112.2 Hz are those of the one-third octaves around 1, 10 and 100 Hz. No study shifts a block's
edges or its frequencies, so blocks are shared.
"""

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from railvib.numerics.jit import fused_kernel

PER_DECADE = 2
STEPS = 25
"""Steps of a block at level 0: 4.7 % each."""
HALO = 5
"""Frequencies tabulated beyond each edge, so that interpolation inside a block needs no neighbour."""
LOWEST = -3
"""First block: below its lower edge, 0.0355 Hz, every response is taken as static."""
SHIFT = 0.05
"""Decimal logarithm of the edge of block 0 in Hz."""
STENCIL = 2 * HALO
"""Points of the interpolation along frequency."""
_DIFFERENCES = np.array([np.prod([i - j for j in range(STENCIL) if j != i]) for i in range(STENCIL)])


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


def stencils(block: int, level: int, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what interpolates from a block's frequencies to others inside it, uniformly in ln f.

    Parameters
    ----------
    f
        Frequencies (n,), Hz.

    Returns
    -------
    first : ndarray of int, shape (n,)
        First of the nearest rows.
    weight : ndarray, shape (n, STENCIL)
        Lagrange weights of these rows.

    Neither is to be written to.
    """
    return _stencils_at(block, level, np.asarray(f, float).tobytes())


@lru_cache(256)
def _stencils_at(block: int, level: int, frequency: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return stencils of frequencies given by their bytes: many receivers ask for the same in turn."""
    f = np.frombuffer(frequency)
    first = np.empty(f.size, np.int64)
    weight = np.empty((f.size, STENCIL))
    _stencils(position(block, level, f), STEPS * 2**level + 2 * HALO + 1, first, weight)
    return first, weight


@fused_kernel
def _stencils(at, rows, first, weight):
    """Write the nearest rows of places among them, and their weights."""
    for i in range(at.shape[0]):
        first[i] = min(max(int(np.floor(at[i])) - HALO + 1, 0), rows - STENCIL)
        away = at[i] - first[i]
        # Of every row the product over all others: those before it times those after it.
        product = 1.0
        for m in range(STENCIL):
            weight[i, m] = product
            product *= away - m
        product = 1.0
        for m in range(STENCIL - 1, -1, -1):
            weight[i, m] *= product / _DIFFERENCES[m]
            product *= away - m


def interpolated(block: int, level: int, f: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Interpolate the rows of a table (frequencies, m) to other frequencies f (n,) in Hz: (n, m)."""
    return combined(*stencils(block, level, f), table)


def combined(
    first: np.ndarray, weight: np.ndarray, table: np.ndarray, out: np.ndarray | None = None
) -> np.ndarray:
    """Return weighted sums (n, m) of neighbouring rows of a table, as `stencils` gives them."""
    rows = np.ascontiguousarray(table)
    if out is None:
        out = np.empty((first.size, rows.shape[1]), rows.dtype)
    _combined(first, weight, rows.view(float), out.view(float))
    return out


@fused_kernel
def _combined(first, weight, table, out):
    """Write the weighted sums of neighbouring rows."""
    for i in range(first.shape[0]):
        combine(first[i], weight[i], table, out[i])


@fused_kernel
def combine(first, weight, table, out):
    """Write a weighted sum of neighbouring rows, as many columns as there is room for."""
    for j in range(out.shape[0]):
        total = 0.0
        for m in range(STENCIL):
            total += weight[m] * table[first + m, j]
        out[j] = total


def halfway(block: int, level: int, number: int) -> np.ndarray:
    """Return a few indices of the next level, half-way between frequencies of this one, across the block."""
    finer = indices(block, level + 1)
    inner = finer[(finer % 2 == 1) & (finer > finer[0] + HALO) & (finer < finer[-1] - HALO)]
    return np.asarray(inner[np.linspace(0, inner.size - 1, number).round().astype(int)])


def assigned(f: np.ndarray, there: Iterable[int]) -> np.ndarray:
    """Return for each frequency in Hz its block, or the nearest of those that are there."""
    nearest = np.floor(PER_DECADE * (np.log10(np.maximum(f, 1e-9)) - SHIFT) + 1e-9)
    return np.asarray(np.clip(nearest, min(there), max(there)), int)


def across(which: np.ndarray, levels: np.ndarray, f: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Interpolate the tables of blocks that follow one another to frequencies in any of them.

    Parameters
    ----------
    which, levels
        Indices and levels of the blocks.
    f
        Frequencies (n,), Hz.
    table
        Their rows, one block's after the other's, (rows, m).

    Returns
    -------
    ndarray, shape (n, m)
    """
    return combined(*_across_at(tuple(which.tolist()), tuple(levels.tolist()), f.tobytes()), table)


@lru_cache(16)
def _across_at(
    which: tuple[int, ...], levels: tuple[int, ...], frequency: bytes
) -> tuple[np.ndarray, np.ndarray]:
    """Return stencils among the rows of blocks that follow one another, as `stencils` does in one."""
    f = np.frombuffer(frequency)
    own = assigned(f, which)
    first = np.empty(f.size, np.int64)
    weight = np.empty((f.size, STENCIL))
    start = 0
    for block, level in zip(which, levels, strict=True):
        here = own == block
        nearest, weight[here] = stencils(block, level, f[here])
        first[here] = start + nearest
        start += indices(block, level).size
    return first, weight


def covering(lower: float, upper: float) -> range:
    """Return the blocks that cover frequencies from `lower` to `upper`, Hz.

    A band that ends at the edge of a block needs no further block: what lies just beyond is in the halo.
    """
    ends = PER_DECADE * (np.log10([lower, upper]) - SHIFT)
    return range(max(int(np.floor(ends[0] + 1e-6)), LOWEST), max(int(np.ceil(ends[1] - 1e-6)), LOWEST + 1))
