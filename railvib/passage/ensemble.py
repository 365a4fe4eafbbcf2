"""Random passages: one fixed ensemble of unevenness, which all cases share."""

from collections.abc import Iterator, Sequence

import numpy as np

from railvib.passage.amplitudes import Block
from railvib.passage.grid import AT_ONCE, Grid


def coefficients(seed: int, batch: int, count: int, harmonics: int, number: int = 0) -> np.ndarray:
    """Return c_n = a_n − i b_n of a batch of passages, complex (passages, harmonics).

    Parameters
    ----------
    seed
        Seed of the ensemble.
    batch
        Which `AT_ONCE` passages.
    count
        How many of them.
    harmonics
        Number of harmonics. More of them leave the first ones as they are.
    number
        Which unevenness, where each axle has its own.
    """
    random = np.random.default_rng([seed, batch, number])
    parts = random.standard_normal((harmonics, AT_ONCE, 2), dtype=np.float32)[:, :count]
    return np.ascontiguousarray(parts[..., 0].T - 1j * parts[..., 1].T)


def batches(passages: int) -> Iterator[tuple[int, int]]:
    """Yield the number and the size of every batch of passages."""
    for batch, first in enumerate(range(0, passages, AT_ONCE)):
        yield batch, min(AT_ONCE, passages - first)


def sampled_lines(amplitudes: Sequence[Block], grid: Grid, seed: int, batch: int, count: int) -> np.ndarray:
    """Return the amplitudes of sampled passages on the lines, complex (passages, lines), m/s.

    In single precision: the error of sampling is many times larger.

    Parameters
    ----------
    amplitudes
        Amplitudes of a receiver.
    grid
        Lines and wavenumbers.
    seed, batch, count
        As for `coefficients`.
    """
    lines = np.zeros((count, grid.frequency.size), np.complex64)
    for number in sorted({block.set for block in amplitudes}):
        random = coefficients(seed, batch, count, grid.wavenumber.size, number)
        conjugate = random.conj()
        for block in amplitudes:
            if block.set == number:
                factor = (conjugate if block.conjugate else random)[:, block.rows]
                lines[:, block.lines] += factor @ block.value
    return lines
