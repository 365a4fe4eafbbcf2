"""Interpolation in a table of transfer functions at scattered pairs of frequency and wavenumber.

Lagrange in ln f, polynomial in a panel of wavenumbers. Points are taken some at a time, so that all that
leads to their weights runs in vector registers; then every point is a short sum over rows of the table.
"""

from typing import NamedTuple

import numba
import numpy as np

from railvib.blocks import STENCIL
from railvib.panels import ORDER, panel_weights, stencil_weights
from railvib.vector_math import LANES, exp


class Places(NamedTuple):
    """Where points lie in a table."""

    row: np.ndarray
    """Fractional numbers of rows, (n,)."""
    dense: np.ndarray
    """β at u = 1 at the points' frequencies, rad/m, (n,)."""
    wavenumber: np.ndarray
    """β, rad/m, (n,), from 0 to `largest`."""
    edge: np.ndarray
    """The panels' edges in u."""
    largest: float
    """β at u = 2, rad/m."""

    def interpolated(self, table: np.ndarray) -> np.ndarray:
        """Return what a complex table (frequency, node) gives at the places, (n,)."""
        rows = np.ascontiguousarray(table, complex).view(float)
        with np.errstate(divide="ignore"):
            octaves = np.log(self.wavenumber / self.dense)
        return np.asarray(
            _interpolated(
                self.row,
                self.dense,
                np.log(self.largest / self.dense),
                self.wavenumber,
                octaves,
                self.edge,
                rows,
            )
        )


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _interpolated(at, dense, octaves, beta, above, edge, table):
    """Interpolate in a table of (frequency, real and imaginary parts in turn at the nodes).

    `octaves` and `above` are ln(largest/dense) and ln(β/dense).
    """
    out = np.empty(at.shape[0], np.complex128)
    row = np.empty(LANES, np.int64)
    panel = np.empty(LANES, np.int64)
    ends = np.empty((2, LANES))
    x = np.empty(LANES)
    stencil = np.empty((STENCIL, LANES))
    basis = np.empty((ORDER, LANES))
    room = np.empty(LANES)
    p = 0
    for first in range(0, at.shape[0], LANES):
        count = min(LANES, at.shape[0] - first)
        for i in range(count):
            row[i] = min(max(int(np.floor(at[first + i])) - STENCIL // 2 + 1, 0), table.shape[0] - STENCIL)
            x[i] = at[first + i] - row[i]
        stencil_weights(count, x, stencil, room)
        for i in range(count):
            n = first + i
            u = beta[n] / dense[n]
            if u > 1.0:
                u = min(1.0 + above[n] / octaves[n], 2.0)
            # Points come in order, more or less: the panel is near that of the point before.
            while p > 0 and u < edge[p]:
                p -= 1
            while p < edge.shape[0] - 2 and u > edge[p + 1]:
                p += 1
            panel[i] = p
            ends[0, i] = edge[p]
            ends[1, i] = edge[p + 1]
        for i in range(count):
            n = first + i
            low = ends[0, i] if ends[1, i] <= 1.0 else exp((ends[0, i] - 1.0) * octaves[n])
            high = ends[1, i] if ends[1, i] <= 1.0 else exp((ends[1, i] - 1.0) * octaves[n])
            x[i] = (2.0 * beta[n] / dense[n] - low - high) / (high - low)
        panel_weights(count, x, basis, room)
        for i in range(count):
            out[first + i] = _value(stencil, basis, i, table, row[i], 2 * ORDER * panel[i])
    return out


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "reassoc"})
def _value(stencil, basis, i, table, row, start):
    """Return the value at point i; nothing is written meanwhile, so that the sums run in vector registers."""
    real = 0.0
    imag = 0.0
    for j in range(ORDER):
        a = 0.0
        b = 0.0
        for m in range(STENCIL):
            a += stencil[m, i] * table[row + m, start + 2 * j]
            b += stencil[m, i] * table[row + m, start + 2 * j + 1]
        real += basis[j, i] * a
        imag += basis[j, i] * b
    return complex(real, imag)
