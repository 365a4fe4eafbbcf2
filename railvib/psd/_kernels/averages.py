"""Sums over panels, axles and points along the line."""

import numpy as np

from railvib.numerics._kernels.lagrange import combine, lagrange_weights
from railvib.numerics._kernels.panels import fourier_integrals
from railvib.numerics.jit import inline, kernel, reduction_kernel
from railvib.numerics.wavenumber_panels import ORDER

_NEGLIGIBLE = 1e-14
"""Share of ∫ |H̃|² below which a panel is skipped."""


@reduction_kernel
def panel_sums(first, stencil, value, panels, weight):
    """Return weighted sums over the nodes of the first panels of rows interpolated to lines, (lines,).

    Parameters
    ----------
    first, stencil
        First row and weights of the rows that are interpolated to each line.
    value
        The rows, (rows, nodes).
    panels
        Number of panels of each line.
    weight
        Weights of the nodes, (lines, nodes).
    """
    out = np.empty(first.shape[0])
    row = np.empty(value.shape[1])
    for i in range(first.shape[0]):
        nodes = ORDER * panels[i]
        combine(first[i], stencil[i], value, row[:nodes])
        total = 0.0
        for j in range(nodes):
            total += weight[i, j] * row[j]
        out[i] = total
    return out


@reduction_kernel
def add_force_products(force, column, out):
    """Add Σ_s Re P_ls* P_ms over the axles l and m at each distance to `out` (lines, distances).

    Forces, (lines, axles, 2·sets), have real and imaginary parts in turn; `column` is the distance of every
    two axles.
    """
    lines, axles, parts = force.shape
    for i in range(lines):
        for k in range(axles):
            for m in range(k + 1):
                total = 0.0
                for n in range(parts):
                    total += force[i, k, n] * force[i, m, n]
                out[i, column[k, m]] += total if m == k else 2.0 * total


@kernel
def add_cosine_integrals(edge, value, distance, out, sine):
    """Add ∫ |H̃|² cos(βd) dβ over the panels that are not negligible to `out` (lines, receivers, distances).

    `value` is |H̃|² on the nodes, (receivers, lines, panels, order). `sine`, (receivers, distances), is
    scratch; its result is unused.
    """
    receivers, lines, panels, _ = value.shape
    needed_value = np.empty((receivers, panels, ORDER))
    centre = np.empty(panels)
    half = np.empty(panels)
    needed = np.empty((receivers, panels), np.bool_)
    for i in range(lines):
        for q in range(receivers):
            _mark_panels(edge[i], value[q, i], needed[q])
        count = 0
        for p in range(panels):
            wanted = False
            for q in range(receivers):
                wanted |= needed[q, p]
            if not wanted:
                continue
            half[count] = 0.5 * (edge[i, p + 1] - edge[i, p])
            centre[count] = 0.5 * (edge[i, p + 1] + edge[i, p])
            for q in range(receivers):
                # Zero where only other receivers need the panel: no result depends on other receivers.
                for j in range(ORDER):
                    needed_value[q, count, j] = value[q, i, p, j] if needed[q, p] else 0.0
            count += 1
        fourier_integrals(centre[:count], half[:count], needed_value, distance, out[i], sine)


@kernel
def _mark_panels(edge, value, needed):
    """Mark the panels with more than a negligible share of one receiver's ∫ |H̃|² dβ."""
    total = 0.0
    for p in range(needed.shape[0]):
        total += _upper_bound(edge, value, p)
    for p in range(needed.shape[0]):
        needed[p] = _upper_bound(edge, value, p) > _NEGLIGIBLE * total


@inline
def _upper_bound(edge, value, p):
    """Return an upper bound of ∫ |H̃|² dβ over a panel."""
    most = 0.0
    for j in range(ORDER):
        most = max(most, value[p, j])
    return most * (edge[p + 1] - edge[p])


@kernel
def axle_products(edge, transfer, grid, at, weight):
    """Return Σ_x w H*(x − α_l) H(x − α_m), (lines, axles, axles).

    Parameters
    ----------
    edge, transfer
        The panels' edges, (lines, edges), and H̃ on their nodes, real and imaginary part, (lines, 2, panels,
        order).
    grid
        Distances at which H is computed, to be interpolated between, m.
    at
        |x − α| of points and axles in steps of the grid, (points, axles).
    weight
        Weights of the points, (points,).
    """
    lines = edge.shape[0]
    axles = at.shape[1]
    out = np.empty((lines, axles, axles), np.complex128)
    response = np.empty((at.shape[0], axles), np.complex128)
    lagrange = np.empty(8)
    sine = np.empty((2, grid.shape[0]))
    cosine = np.empty((2, grid.shape[0]))
    for i in range(lines):
        half = 0.5 * (edge[i, 1:] - edge[i, :-1])
        centre = 0.5 * (edge[i, 1:] + edge[i, :-1])
        cosine[:] = 0.0
        fourier_integrals(centre, half, transfer[i], grid, cosine, sine)
        line = (cosine[0] + 1j * cosine[1]) / np.pi
        for j in range(at.shape[0]):
            for axle in range(axles):
                first = min(max(int(at[j, axle]) - 3, 0), grid.shape[0] - 8)
                lagrange_weights(at[j, axle] - first, lagrange)
                value = 0j
                for m in range(8):
                    value += lagrange[m] * line[first + m]
                response[j, axle] = value
        for one in range(axles):
            for other in range(axles):
                total = 0j
                for j in range(at.shape[0]):
                    total += weight[j] * np.conj(response[j, one]) * response[j, other]
                out[i, one, other] = total
    return out
