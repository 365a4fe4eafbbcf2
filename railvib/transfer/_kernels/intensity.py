"""|H̃|² on the nodes of tables. Complex arrays hold real and imaginary parts in turn, (n, 2·m)."""

import numpy as np

from railvib.numerics._kernels.lagrange import combine
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import LANES, exp
from railvib.numerics.wavenumber_panels import NODE, ORDER
from railvib.transfer._kernels.track import track_under_unit_force
from railvib.transfer._kernels.waves import MOST_DECAY


@fused_kernel
def square_rows(value, rows, places, out):
    """Write |value|² of some rows to rows of the output, `places`."""
    for i in range(rows.shape[0]):
        row = value[rows[i]]
        for j in range(out.shape[1]):
            out[places[i], j] = row[2 * j] * row[2 * j] + row[2 * j + 1] * row[2 * j + 1]


@fused_kernel
def squares_on_track(first, weight, compliance, edge, omega, bed, support, pad, rail):
    """Return |H̃|² of the rail and of the ground under it, and |force on the ground|²; (3, lines, nodes)."""
    nodes = ORDER * (edge.shape[1] - 1)
    out = np.empty((3, edge.shape[0], nodes))
    q = np.empty(6 * LANES)
    under = np.empty(2 * nodes)
    beta = np.empty(nodes)
    for i in range(edge.shape[0]):
        _write_nodes(np.inf, edge[i], beta)
        combine(first[i], weight[i], compliance, under)
        for start in range(0, nodes, LANES):
            m = min(LANES, nodes - start)
            for j in range(m):
                q[j] = under[2 * (start + j)]
                q[LANES + j] = under[2 * (start + j) + 1]
                q[4 * LANES + j] = beta[start + j]
                q[5 * LANES + j] = omega[i]
            track_under_unit_force(m, q, bed, support, pad, rail)
            for j in range(m):
                force = 1.0 / (q[2 * LANES + j] ** 2 + q[3 * LANES + j] ** 2)
                c = under[2 * (start + j)] ** 2 + under[2 * (start + j) + 1] ** 2
                out[0, i, start + j] = force * (q[j] ** 2 + q[LANES + j] ** 2)
                out[1, i, start + j] = force * c
                out[2, i, start + j] = force
    return out


@fused_kernel
def multiply_by_squares(first, weight, reduced, edge, omega, slowness, distance, last, out):
    """Multiply by |interpolated rows|² e^{−2κ·distance}, κ² = β² − (ω·slowness)², on panels below `last`."""
    row = np.empty(2 * out.shape[1])
    beta = np.empty(out.shape[1])
    for i in range(out.shape[0]):
        end = _write_nodes(last[i], edge[i], beta)
        combine(first[i], weight[i], reduced, row[: 2 * end])
        for j in range(end):
            square = row[2 * j] * row[2 * j] + row[2 * j + 1] * row[2 * j + 1]
            k = omega[i] * slowness[j]
            kappa = np.sqrt(max(beta[j] * beta[j] - k * k, 0.0))
            out[i, j] *= square * exp(-2.0 * min(kappa * distance, MOST_DECAY))
        for j in range(end, out.shape[1]):
            out[i, j] = 0.0


@fused_kernel
def _write_nodes(last, edge, beta):
    """Write the nodes of the panels that begin below a wavenumber, and return their number."""
    end = 0
    while end < edge.shape[0] - 1 and edge[end] < last:
        middle = 0.5 * (edge[end + 1] + edge[end])
        half = 0.5 * (edge[end + 1] - edge[end])
        for j in range(ORDER):
            beta[end * ORDER + j] = middle + half * NODE[j]
        end += 1
    return end * ORDER
