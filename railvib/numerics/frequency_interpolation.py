"""Interpolation along frequency, in tables over the frequencies of blocks."""

from functools import lru_cache

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics._kernels import lagrange
from railvib.numerics.frequency_blocks import STENCIL


def stencils(block: int, level: int, frequency: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of a block's table and their weights that interpolate, as polynomials in ln f.

    Parameters
    ----------
    block, level
        The block, and the level of its table's frequencies.
    frequency
        Frequencies inside the block, (n,), Hz.

    Returns
    -------
    first : ndarray of int, shape (n,)
        First of the `STENCIL` nearest rows. Not to be written to.
    weight : ndarray, shape (n, STENCIL)
        Lagrange weights of these rows. Not to be written to.
    """
    return _stencils(block, level, np.asarray(frequency, float).tobytes())


@lru_cache(256)
def _stencils(block: int, level: int, frequency: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return stencils of frequencies given by their bytes: many receivers ask for the same in turn."""
    f = np.frombuffer(frequency)
    first = np.empty(f.size, np.int64)
    weight = np.empty((f.size, STENCIL))
    rows = blocks.indices(block, level).size
    lagrange.stencils(blocks.position(block, level, f), rows, first, weight)
    return first, weight


def interpolate(block: int, level: int, frequency: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Return the rows (n, m) of a block's table (frequencies, m) at frequencies (n,) in Hz inside it."""
    return combine_rows(*stencils(block, level, frequency), table)


def combine_rows(
    first: np.ndarray, weight: np.ndarray, table: np.ndarray, out: np.ndarray | None = None
) -> np.ndarray:
    """Return the weighted sums (n, m) of neighbouring rows of a table, as `stencils` gives them."""
    rows = np.ascontiguousarray(table)
    if out is None:
        out = np.empty((first.size, rows.shape[1]), rows.dtype)
    lagrange.combine_rows(first, weight, rows.view(float), out.view(float))
    return out


def interpolate_blocks(
    block: np.ndarray, level: np.ndarray, frequency: np.ndarray, table: np.ndarray
) -> np.ndarray:
    """Interpolate the tables of blocks that follow one another to frequencies in any of them.

    Parameters
    ----------
    block, level
        The blocks, and the levels of their tables.
    frequency
        Frequencies (n,), Hz.
    table
        Their rows, one block's after the other's, (rows, m).

    Returns
    -------
    ndarray, shape (n, m)
    """
    stencil = _stencils_of_blocks(tuple(block.tolist()), tuple(level.tolist()), frequency.tobytes())
    return combine_rows(*stencil, table)


@lru_cache(16)
def _stencils_of_blocks(
    block: tuple[int, ...], level: tuple[int, ...], frequency: bytes
) -> tuple[np.ndarray, np.ndarray]:
    """Return stencils among the rows of blocks that follow one another, as `stencils` does in one."""
    f = np.frombuffer(frequency)
    blocks.check_coverage(f, block)
    block_of = blocks.nearest_block(f, block)
    first = np.empty(f.size, np.int64)
    weight = np.empty((f.size, STENCIL))
    start = 0
    for index, index_level in zip(block, level, strict=True):
        inside = block_of == index
        nearest, weight[inside] = stencils(index, index_level, f[inside])
        first[inside] = start + nearest
        start += blocks.indices(index, index_level).size
    return first, weight
