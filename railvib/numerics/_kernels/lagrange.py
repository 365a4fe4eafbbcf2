"""Lagrange interpolation: among the frequencies of a block, and at the nodes of a panel of wavenumbers."""

import numpy as np

from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.jit import fused_kernel, inline
from railvib.numerics.wavenumber_panels import BARYCENTRIC, NODE

_DIFFERENCES = np.array([np.prod([i - j for j in range(STENCIL) if j != i]) for i in range(STENCIL)])
_EQUIDISTANT = np.arange(STENCIL, dtype=float)
_OVER_DIFFERENCES = np.array(
    [1.0 / np.prod(point - np.delete(_EQUIDISTANT, i)) for i, point in enumerate(_EQUIDISTANT)]
)


@fused_kernel
def stencils(at, rows, first, weight):
    """Write the first of the rows nearest to places among them, and the weights of these rows."""
    for i in range(at.shape[0]):
        first[i] = min(max(int(np.floor(at[i])) - STENCIL // 2 + 1, 0), rows - STENCIL)
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


@fused_kernel
def combine_rows(first, weight, table, out):
    """Write the weighted sums of neighbouring rows."""
    for i in range(first.shape[0]):
        combine(first[i], weight[i], table, out[i])


@fused_kernel
def combine(first, weight, table, out):
    """Write a weighted sum of neighbouring rows, of as many columns as `out` has."""
    for j in range(out.shape[0]):
        total = 0.0
        for m in range(STENCIL):
            total += weight[m] * table[first + m, j]
        out[j] = total


@fused_kernel
def panel_weights(count, x, weight, scratch):
    """Write the weights of a panel's nodes for interpolation at `count` places x in [−1, 1].

    Parameters
    ----------
    count
        Number of places.
    x
        The places, at least (count,).
    weight
        Where the weights are written, (order, at least count).
    scratch
        At least (count,); its result is unused.
    """
    _lagrange_products(count, x, NODE, BARYCENTRIC, weight, scratch)


@fused_kernel
def stencil_weights(count, t, weight, scratch):
    """Write the weights of equidistant points 0, 1, … for interpolation at places t, as `panel_weights`."""
    _lagrange_products(count, t, _EQUIDISTANT, _OVER_DIFFERENCES, weight, scratch)


@inline
def _lagrange_products(count, x, node, factor, weight, product):
    """Write Lagrange's weights: without a division, and exact on the nodes."""
    nodes = node.shape[0]
    for i in range(count):
        product[i] = 1.0
    for k in range(nodes):
        for i in range(count):
            weight[k, i] = product[i]
            product[i] *= x[i] - node[k]
    for i in range(count):
        product[i] = 1.0
    for k in range(nodes - 1, -1, -1):
        for i in range(count):
            weight[k, i] *= factor[k] * product[i]
            product[i] *= x[i] - node[k]


@inline
def lagrange_weights(t, weight):
    """Write the weights of eight equidistant points 0 … 7 for interpolation at t."""
    a0 = t
    a1 = t - 1.0
    a2 = t - 2.0
    a3 = t - 3.0
    a4 = t - 4.0
    a5 = t - 5.0
    a6 = t - 6.0
    a7 = t - 7.0
    a01 = a0 * a1
    a23 = a2 * a3
    a45 = a4 * a5
    a67 = a6 * a7
    low = a01 * a23
    high = a45 * a67
    weight[0] = -a1 * a23 * high / 5040.0
    weight[1] = a0 * a23 * high / 720.0
    weight[2] = -a01 * a3 * high / 240.0
    weight[3] = a01 * a2 * high / 144.0
    weight[4] = -low * a5 * a67 / 144.0
    weight[5] = low * a4 * a67 / 240.0
    weight[6] = -low * a45 * a7 / 720.0
    weight[7] = low * a45 * a6 / 5040.0
