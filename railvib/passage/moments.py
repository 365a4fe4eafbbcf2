"""What holds of all passages: variance of velocity over time, exactly and without sampling.

    σ²(t) = Σ_n |U_n(t)|² = Re Σ_d S_d e^{2πi dΔf t},        S_d = Σ_n Σ_j Ū_nj U_n,j+d

The terms at sums of two lines, which U_n(t) has where lines of negative frequency are heard, are left out:
they turn at twice the frequency of the velocity.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import fft

from railvib.passage.amplitudes import Block
from railvib.passage.grid import Grid

_ROWS_AT_ONCE = 128
"""Harmonics whose lines are in memory together."""


def variance_spectra(
    amplitudes: Sequence[Block], grid: Grid, responses: Sequence[np.ndarray], count: int
) -> np.ndarray:
    """Return S_d of weighted velocities, complex (responses, count), (m/s)² times the squared responses.

    Parameters
    ----------
    amplitudes
        Amplitudes of a receiver.
    grid
        Lines and wavenumbers.
    responses
        Responses of weightings to velocity on the lines, complex (lines,) each.
    count
        Number of differences d, from 0 on, twice those of d > 0 included.
    """
    spectra = np.zeros((len(responses), count), complex)
    for first, value in _complete(amplitudes, grid):
        width = value.shape[1]
        size = fft.next_fast_len(width + min(count, width))
        for row, response in zip(spectra, responses, strict=True):
            local = value * response[first : first + width].astype(np.complex64)
            power = fft.fft(local, size, axis=1)
            total = np.einsum("nk,nk->k", power.view(np.float32)[:, 0::2], power.view(np.float32)[:, 0::2])
            total += np.einsum("nk,nk->k", power.view(np.float32)[:, 1::2], power.view(np.float32)[:, 1::2])
            # Σ_j Ū_j U_{j+d} is the inverse transform of |Û|².
            products = fft.ifft(total.astype(float))[: min(count, width)]
            row[: products.size] += products
    spectra[:, 1:] *= 2.0
    return spectra


def over_time(spectra: np.ndarray, samples: int) -> np.ndarray:
    """Return Re Σ_d S_d e^{2πi dΔf t} at a number of times in the record, (..., samples)."""
    padded = np.zeros((*spectra.shape[:-1], samples // 2 + 1), complex)
    count = min(spectra.shape[-1], padded.shape[-1])
    padded[..., :count] = spectra[..., :count]
    padded[..., 1:] *= 0.5
    return np.asarray(fft.irfft(padded, samples) * samples)


def _complete(amplitudes: Sequence[Block], grid: Grid) -> Iterator[tuple[int, np.ndarray]]:
    """Yield groups of harmonics with all their lines: the first line, and complex (harmonics, lines)."""
    for conjugate in (False, True):
        for number in sorted({block.set for block in amplitudes}):
            chosen = [block for block in amplitudes if (block.conjugate, block.set) == (conjugate, number)]
            for start in range(0, grid.wavenumber.size, _ROWS_AT_ONCE):
                stop = start + _ROWS_AT_ONCE
                parts = [block for block in chosen if block.rows.start < stop and block.rows.stop > start]
                if not parts:
                    continue
                first = min(block.lines.start for block in parts)
                value = np.zeros(
                    (_ROWS_AT_ONCE, max(block.lines.stop for block in parts) - first), np.complex64
                )
                for block in parts:
                    low, high = max(block.rows.start, start), min(block.rows.stop, stop)
                    lines = slice(block.lines.start - first, block.lines.stop - first)
                    value[low - start : high - start, lines] += block.value[
                        low - block.row : high - block.row
                    ]
                yield first, value
