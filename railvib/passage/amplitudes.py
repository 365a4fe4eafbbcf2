"""Amplitudes of a passage: what each harmonic of the unevenness gives on each line of frequency.

    v(t) = m(t) + Re Σ_n c_n U_n(t),        U_n(t) = Σ_j U_nj e^{2πi f_j t},        c_n = a_n − i b_n

with a_n and b_n normal, of variance 1. Lines of negative frequency are kept at their positive frequency,
where c_n is replaced by its conjugate. The clock shows 0 when the middle of the train passes, in the middle
of the record.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.vector_math import phasors
from railvib.numerics.wavenumber_panels import FROM_POWERS, ORDER, WEIGHT
from railvib.passage._kernels.panel_series import evaluate_series
from railvib.passage.grid import Grid
from railvib.transfer.transfer_function import TransferFunction

_NEGLIGIBLE = 1e-13
"""Share of ∫ |H̃|² dκ beyond which the response to a wavenumber is left out."""
_TRIM = 1e-6
"""Share of a line's energy that may be left out with the outermost harmonics on either side."""


class Block(NamedTuple):
    """Amplitudes of neighbouring harmonics on neighbouring lines."""

    row: int
    """Index of the first harmonic."""
    line: int
    """Index of the first line."""
    value: np.ndarray
    """U_nj, complex (harmonics, lines), m/s, in single precision: 1e-7 of the largest."""
    conjugate: bool
    """Whether c_n is replaced by its conjugate."""
    set: int
    """Which unevenness: 0, or the axle under which it lies."""

    @property
    def rows(self) -> slice:
        """The harmonics."""
        return slice(self.row, self.row + self.value.shape[0])

    @property
    def lines(self) -> slice:
        """The lines."""
        return slice(self.line, self.line + self.value.shape[1])


def trimmed(block: Block) -> Block | None:
    """Return a block without outermost harmonics of negligible energy; None if nothing is left."""
    energy = block.value.real**2 + block.value.imag**2
    total = energy.sum(axis=0)
    if not np.any(total > 0.0):
        return None
    # By lines: a weak line keeps what it has beside strong ones.
    share = energy @ np.where(total > 0.0, 1.0 / np.maximum(total, 1e-300), 0.0)
    first = int(np.searchsorted(np.cumsum(share), _TRIM))
    last = share.size - int(np.searchsorted(np.cumsum(share[::-1]), _TRIM))
    value = block.value[first:last].astype(np.complex64)
    return block._replace(row=block.row + first, value=value)


def line_energies(blocks_of: Iterable[Block], lines: int) -> np.ndarray:
    """Return Σ_n |U_nj|² of every line, (lines,), (m/s)²."""
    energy = np.zeros(lines)
    for block in blocks_of:
        energy[block.lines] += np.einsum("nj,nj->j", block.value, block.value.conj()).real
    return energy


def psd_over_passage(blocks_of: Iterable[Block], grid: Grid, duration: float) -> np.ndarray:
    """Return the one-sided PSD averaged over the passage's duration in s, (m/s)²/Hz, (lines,)."""
    return line_energies(blocks_of, grid.frequency.size) / (grid.step**2 * duration)


def time_shift(grid: Grid, train_length: float, speed: float) -> float:
    """Return what is added to α so that the middle of the train passes in the middle of the record, m."""
    return -0.5 * train_length - 0.5 * speed / grid.step


def line_phases(frequency: np.ndarray, position: np.ndarray, speed: float) -> np.ndarray:
    """Return e^{2πi f α/v}, complex (lines, axles)."""
    return phasors(2.0 * np.pi / speed * frequency[:, None] * position)


class Response(NamedTuple):
    """H̃ of a receiver at some frequencies as polynomials over panels of wavenumber."""

    edge: np.ndarray
    series: np.ndarray

    @classmethod
    def of(cls, function: TransferFunction, frequency: np.ndarray) -> list[tuple[slice, "Response"]]:
        """Return the responses at ascending frequencies (n,) in Hz, table by table."""
        block_of = blocks.nearest_block(frequency, function.blocks)
        parts = []
        for block in np.unique(block_of):
            inside = np.flatnonzero(block_of == block)
            f = frequency[inside]
            _beta, value = function.at(int(block), f)
            edge = function.blocks[int(block)].nodes.panel_edges(f)
            value = value.reshape(f.size, -1, ORDER)
            energy = (np.abs(value) ** 2 @ WEIGHT) * np.diff(edge)
            tail = np.cumsum(energy[:, ::-1], axis=1)[:, ::-1]
            panels = int((tail > _NEGLIGIBLE * tail[:, :1]).sum(axis=1).max())
            series = value[:, :panels].reshape(-1, ORDER).view(float).reshape(-1, ORDER, 2)
            powers = np.einsum("pnc,kn->pkc", series, FROM_POWERS, optimize=True)
            powers = np.ascontiguousarray(powers).view(complex)[..., 0].reshape(f.size, panels, ORDER)
            parts.append(
                (slice(inside[0], inside[-1] + 1), cls(np.ascontiguousarray(edge[:, : panels + 1]), powers))
            )
        return parts

    @property
    def reach(self) -> float:
        """Largest |κ| at which there is a response, rad/m."""
        return float(self.edge[:, -1].max())

    def at(self, kappa: np.ndarray) -> np.ndarray:
        """Return H̃ at ascending wavenumbers (frequencies, points), m²/N."""
        out = np.empty(kappa.shape, complex)
        evaluate_series(self.edge, self.series, kappa, out)
        return out
