"""Interpolation in tables at scattered pairs of frequency and wavenumber.

Points are taken `LANES` at a time, whichever blocks they lie in, so that everything that leads to their
weights runs in vector registers; then every point is a short sum over rows of its table. The scratch array
has a row for each quantity, and a column for each of these points.
"""

import numpy as np

from railvib.numerics._kernels.lagrange import panel_weights, stencil_weights
from railvib.numerics.frequency_blocks import HALO, PER_DECADE, SHIFT, STENCIL
from railvib.numerics.intrinsics import bilinear_sum
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import LANES, exp, log
from railvib.numerics.wavenumber_panels import ORDER

_DECADE = np.log(10.0)
_FREQUENCY, _BETA = 0, 1
_LOG_FREQUENCY, _LOG_BETA = 2, 3
_ROW, _LOG_LARGEST, _U = 2, 3, 4
"""Place among the stencil's rows; logarithm of the largest β over that at u = 1; β over that at u = 1."""
_LOW, _HIGH = 5, 6
"""The panel's edges in u."""
_PLACE = 4
"""Place in the panel, from −1 to 1."""
_STENCIL = 7
_BASIS = _STENCIL + STENCIL
"""First rows of the weights along frequency and along wavenumber."""
_sum_bilinear = bilinear_sum(STENCIL, ORDER, LANES, _STENCIL, _BASIS)


@fused_kernel
def interpolate_points(tables, frequency, wavenumber, out):
    """Interpolate at points; the last one fills up the lanes."""
    scratch = np.empty((_BASIS + ORDER, LANES))
    start = np.empty(LANES, np.int64)
    width = np.empty(LANES, np.int64)
    stencil = scratch[_STENCIL:_BASIS]
    basis = scratch[_BASIS:]
    points = frequency.shape[0]
    for first in range(0, points, LANES):
        for i in range(LANES):
            point = min(first + i, points - 1)
            scratch[_FREQUENCY, i] = frequency[point]
            scratch[_BETA, i] = wavenumber[point]
        for i in range(LANES):
            scratch[_LOG_FREQUENCY, i] = log(scratch[_FREQUENCY, i])
            scratch[_LOG_BETA, i] = log(max(scratch[_BETA, i], 1e-200))
        _locate(tables, scratch, start, width)
        for i in range(LANES):
            # From u to β at both ends of the panel: proportional up to u = 1, beyond geometric.
            octaves = scratch[_LOG_LARGEST, i]
            low = min(scratch[_LOW, i], 1.0) * exp(max(scratch[_LOW, i] - 1.0, 0.0) * octaves)
            high = min(scratch[_HIGH, i], 1.0) * exp(max(scratch[_HIGH, i] - 1.0, 0.0) * octaves)
            scratch[_PLACE, i] = (2.0 * scratch[_U, i] - low - high) / (high - low)
        stencil_weights(np.int64(LANES), scratch[_ROW], stencil, scratch[_LOG_LARGEST])
        panel_weights(np.int64(LANES), scratch[_PLACE], basis, scratch[_LOG_LARGEST])
        for i in range(min(LANES, points - first)):
            out[first + i] = _sum_bilinear(tables.value, start[i], width[i], scratch, i)


@fused_kernel
def _locate(tables, scratch, start, width):
    """Find the rows and the panel of every point: where its values start, and its table's row length."""
    p = 0
    for i in range(LANES):
        at = (scratch[_LOG_FREQUENCY, i] / _DECADE - SHIFT) * PER_DECADE
        block = min(max(int(np.floor(at + 1e-9)) - tables.first_block, 0), tables.steps.shape[0] - 1)
        value_start, edge_start, rows, numbers, edges = tables.place[block]
        at = (at - (block + tables.first_block)) * tables.steps[block] + HALO
        row = min(max(int(np.floor(at)) - STENCIL // 2 + 1, 0), rows - STENCIL)
        logarithm = scratch[_LOG_FREQUENCY, i] + tables.dense[1, block]
        octaves = tables.largest[block] - logarithm
        u = scratch[_BETA, i] / (scratch[_FREQUENCY, i] * tables.dense[0, block])
        scratch[_U, i] = u
        if u > 1.0:
            u = min(1.0 + (scratch[_LOG_BETA, i] - logarithm) / octaves, 2.0)
        scratch[_ROW, i] = at - row
        scratch[_LOG_LARGEST, i] = octaves
        # Points come more or less in order: the panel is near that of the point before.
        p = min(p, edges - 2)
        while p > 0 and u < tables.edge[edge_start + p]:
            p -= 1
        while p < edges - 2 and u > tables.edge[edge_start + p + 1]:
            p += 1
        scratch[_LOW, i] = tables.edge[edge_start + p]
        scratch[_HIGH, i] = tables.edge[edge_start + p + 1]
        start[i] = value_start + row * numbers + 2 * ORDER * p
        width[i] = numbers
