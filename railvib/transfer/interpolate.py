"""Interpolation in tables of transfer functions at scattered pairs of frequency and wavenumber.

Lagrange in ln f, polynomial in a panel of wavenumbers. Points are taken some at a time, whichever blocks they
lie in, so that all that leads to their weights runs in vector registers; then every point is a short sum over
rows of its table.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from railvib.numerics.frequency_blocks import HALO, PER_DECADE, SHIFT, STENCIL, STEPS
from railvib.numerics.intrinsics import bilinear_sum
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import LANES, exp, log
from railvib.numerics.wavenumber_panels import ORDER, panel_weights, stencil_weights

_DECADE = np.log(10.0)


class Tables(NamedTuple):
    """Tables of one function over neighbouring blocks, end to end, as compiled kernels read them."""

    value: np.ndarray
    """Row by row, real and imaginary parts in turn."""
    first_block: int
    place: np.ndarray
    """Per block: where its values and its edges start, number of rows, of numbers in a row, and of edges."""
    steps: np.ndarray
    """Frequencies per block."""
    edge: np.ndarray
    """The panels' edges in u."""
    dense: np.ndarray
    """Per block β at u = 1 over the frequency, rad/m/Hz, and its logarithm."""
    largest: np.ndarray
    """Logarithm of β at u = 2."""


class Rows(NamedTuple):
    """The table of one block: what `Tables` are made of."""

    block: int
    level: int
    top_slowness: float
    largest: float
    edge: np.ndarray
    value: np.ndarray
    """Complex (frequency, node)."""


def joined(rows: Sequence[Rows]) -> Tables:
    """Return tables of neighbouring blocks, ascending, as one."""
    flat = [np.ascontiguousarray(each.value, complex).view(float).ravel() for each in rows]
    edges = [each.edge for each in rows]
    starts = np.cumsum([0] + [each.size for each in flat])
    edge_starts = np.cumsum([0] + [each.size for each in edges])
    place = [
        (starts[i], edge_starts[i], each.value.shape[0], 2 * each.value.shape[1], each.edge.size)
        for i, each in enumerate(rows)
    ]
    dense = 2.0 * np.pi * np.array([each.top_slowness for each in rows])
    return Tables(
        flat[0] if len(flat) == 1 else np.concatenate(flat),
        rows[0].block,
        np.array(place, np.int64),
        STEPS * 2.0 ** np.array([each.level for each in rows]),
        np.concatenate(edges),
        np.stack([dense, np.log(dense)]),
        np.log([each.largest for each in rows]),
    )


def interpolated(tables: Tables, frequency: np.ndarray, wavenumber: np.ndarray) -> np.ndarray:
    """Return what tables give at frequencies in Hz and wavenumbers in rad/m from 0 to their largest."""
    out = np.empty(frequency.size, complex)
    _interpolated(tables, frequency.ravel(), wavenumber.ravel(), out)
    return out.reshape(frequency.shape)


_STENCIL_AT = 7
_BASIS_AT = _STENCIL_AT + STENCIL
_sum_bilinear = bilinear_sum(STENCIL, ORDER, LANES, _STENCIL_AT, _BASIS_AT)


@fused_kernel
def _interpolated(tables, frequency, wavenumber, out):
    """Interpolate at points; the last ones fill up what goes through the loops together."""
    room = np.empty((_BASIS_AT + ORDER, LANES))
    start = np.empty(LANES, np.int64)
    width = np.empty(LANES, np.int64)
    stencil = room[_STENCIL_AT:_BASIS_AT]
    basis = room[_BASIS_AT:]
    points = frequency.shape[0]
    for first in range(0, points, LANES):
        for i in range(LANES):
            own = min(first + i, points - 1)
            room[0, i] = frequency[own]
            room[1, i] = wavenumber[own]
        for i in range(LANES):
            room[2, i] = log(room[0, i])
            room[3, i] = log(max(room[1, i], 1e-200))
        _find(tables, room, start, width)
        for i in range(LANES):
            # From u to β at both ends of the panel: proportional up to u = 1, beyond geometric.
            low = min(room[5, i], 1.0) * exp(max(room[5, i] - 1.0, 0.0) * room[3, i])
            high = min(room[6, i], 1.0) * exp(max(room[6, i] - 1.0, 0.0) * room[3, i])
            room[4, i] = (2.0 * room[4, i] - low - high) / (high - low)
        stencil_weights(np.int64(LANES), room[2], stencil, room[3])
        panel_weights(np.int64(LANES), room[4], basis, room[3])
        for i in range(min(LANES, points - first)):
            out[first + i] = _sum_bilinear(tables.value, start[i], width[i], room, i)


@fused_kernel
def _find(tables, room, start, width):
    """Find the rows and the panel of every point.

    `room` holds frequencies, wavenumbers, and the logarithms of both; then, from 2 on, where points lie among
    their rows, the logarithm of the largest β over that at u = 1, β over that at u = 1, and the panel's edges
    in u.
    """
    p = 0
    for i in range(LANES):
        at = (room[2, i] / _DECADE - SHIFT) * PER_DECADE
        block = min(max(int(np.floor(at + 1e-9)) - tables.first_block, 0), tables.steps.shape[0] - 1)
        value_start, edge_start, rows, numbers, edges = tables.place[block]
        at = (at - (block + tables.first_block)) * tables.steps[block] + HALO
        row = min(max(int(np.floor(at)) - STENCIL // 2 + 1, 0), rows - STENCIL)
        logarithm = room[2, i] + tables.dense[1, block]
        octaves = tables.largest[block] - logarithm
        u = room[1, i] / (room[0, i] * tables.dense[0, block])
        room[4, i] = u
        if u > 1.0:
            u = min(1.0 + (room[3, i] - logarithm) / octaves, 2.0)
        room[2, i] = at - row
        room[3, i] = octaves
        # Points come in order, more or less: the panel is near that of the point before.
        p = min(p, edges - 2)
        while p > 0 and u < tables.edge[edge_start + p]:
            p -= 1
        while p < edges - 2 and u > tables.edge[edge_start + p + 1]:
            p += 1
        room[5, i] = tables.edge[edge_start + p]
        room[6, i] = tables.edge[edge_start + p + 1]
        start[i] = value_start + row * numbers + 2 * ORDER * p
        width[i] = numbers
