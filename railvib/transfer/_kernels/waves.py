"""Reference waves, taken out of a transfer function before interpolating and put back afterwards.

Complex arrays hold real and imaginary parts in turn, (n, 2·m).
"""

import numpy as np

from railvib.numerics._kernels.lagrange import panel_weights
from railvib.numerics._kernels.panels import count_below
from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import cos_sin, exp
from railvib.numerics.wavenumber_panels import NODE, ORDER

MOST_DECAY = 60.0
"""Exponent at which the decay of a reference wave is cut off."""


@fused_kernel
def multiply_by_waves(value, factor, omega, slowness, beta, distance, sign, out):
    """Write values times a factor times the waves' decay, or divided by the decay where the sign is −1.

    Values are (n, 2·m); the factor has as many rows, or one for all.
    """
    wave = np.empty((2, beta.shape[1]))
    for i in range(beta.shape[0]):
        reference_waves(omega[i], slowness, beta[i], distance, sign, wave[0], wave[1])
        times = factor[min(i, factor.shape[0] - 1)]
        for j in range(beta.shape[1]):
            a = value[i, 2 * j] * times[2 * j] - value[i, 2 * j + 1] * times[2 * j + 1]
            b = value[i, 2 * j] * times[2 * j + 1] + value[i, 2 * j + 1] * times[2 * j]
            out[i, 2 * j] = a * wave[0, j] - b * wave[1, j]
            out[i, 2 * j + 1] = a * wave[1, j] + b * wave[0, j]


@fused_kernel
def interpolate_with_waves(first, weight, reduced, edge, omega, slowness, beta, distance):
    """Return reduced rows interpolated to points, times the waves' decay, real and imaginary part, (n, 2).

    The decay is put back at the nodes of a point's panel: the panels resolve the whole function, but not the
    decay of a wave, which has a branch point where β is its wavenumber. Along a panel a field may fall by
    many orders of magnitude: an exponential that falls as much is taken out before interpolating on the
    panel.
    """
    out = np.empty((beta.shape[0], 2))
    node = np.empty(ORDER)
    row = np.empty(2 * ORDER)
    wave = np.empty((2, ORDER))
    basis = np.empty((ORDER, 1))
    x = np.empty((2, 1))
    one = np.int64(1)
    for i in range(beta.shape[0]):
        p = min(max(count_below(edge[i], beta[i]) - 1, 0), edge.shape[1] - 2)
        middle = 0.5 * (edge[i, p + 1] + edge[i, p])
        half = 0.5 * (edge[i, p + 1] - edge[i, p])
        for j in range(ORDER):
            node[j] = middle + half * NODE[j]
            row[2 * j] = 0.0
            row[2 * j + 1] = 0.0
        for m in range(STENCIL):
            for j in range(2 * ORDER):
                row[j] += weight[i, m] * reduced[first[i] + m, 2 * ORDER * p + j]
        wave_slowness = slowness[ORDER * p : ORDER * (p + 1)]
        reference_waves(omega[i], wave_slowness, node, distance, 1.0, wave[0], wave[1])
        k = omega[i] * wave_slowness[0]
        fall = np.sqrt(max(edge[i, p + 1] ** 2 - k * k, 0.0)) - np.sqrt(max(edge[i, p] ** 2 - k * k, 0.0))
        slope = min(fall * distance, MOST_DECAY) / (2.0 * half)
        x[0, 0] = (beta[i] - middle) / half
        panel_weights(one, x[0], basis, x[1])
        out[i, 0] = 0.0
        out[i, 1] = 0.0
        for j in range(ORDER):
            basis[j, 0] *= exp(slope * (node[j] - beta[i]))
            out[i, 0] += basis[j, 0] * (row[2 * j] * wave[0, j] - row[2 * j + 1] * wave[1, j])
            out[i, 1] += basis[j, 0] * (row[2 * j] * wave[1, j] + row[2 * j + 1] * wave[0, j])
    return out


@fused_kernel
def reference_waves(omega, slowness, beta, distance, sign, real, imag):
    """Write e^{∓κ·distance}, κ² = β² − (ω·slowness)², for one slowness per β; the exponent is cut off."""
    start = 0
    while start < beta.shape[0]:
        travels = beta[start] < omega * slowness[start]
        end = start + 1
        while end < beta.shape[0] and (beta[end] < omega * slowness[end]) == travels:
            end += 1
        # Views that start at 0 let the compiler vectorise the loops.
        b = beta[start:end]
        s = slowness[start:end]
        re = real[start:end]
        im = imag[start:end]
        if travels:
            for j in range(b.shape[0]):
                k = omega * s[j]
                c, t = cos_sin(np.sqrt(abs(k * k - b[j] * b[j])) * distance)
                re[j] = c
                im[j] = -sign * t
        else:
            for j in range(b.shape[0]):
                k = omega * s[j]
                re[j] = exp(-sign * min(np.sqrt(abs(b[j] * b[j] - k * k)) * distance, MOST_DECAY))
                im[j] = 0.0
        start = end


@fused_kernel
def largest_errors(value, rows, stencil, places, force, direct, size, slowness, panels, distance):
    """Return the largest relative error of each panel at some places with waves taken out, (sets, panels).

    Parameters
    ----------
    value
        Values at the rows, (rows, 2·nodes): interpolated without the waves' decay, then multiplied by the
        decay at the places and by `force`.
    rows, places
        Wavenumbers, (n, nodes), and angular frequencies, (n,), of the rows and of the places.
    stencil
        First row and weights of the rows that are interpolated to each place.
    force, direct, size
        At the places: factor of the interpolated values, (n, 2·nodes), values to compare them with, and the
        size that errors are relative to.
    slowness
        Sets of the waves' slownesses, (sets, nodes).
    panels
        Number of panels.
    distance
        Distance that the waves travel, m.
    """
    row_beta, row_omega = rows
    first, weight = stencil
    beta, omega = places
    nodes = beta.shape[1]
    order = nodes // panels
    out = np.empty((slowness.shape[0], panels))
    term = np.empty((2, nodes))
    total = np.empty((2, nodes))
    for c in range(slowness.shape[0]):
        for p in range(out.shape[1]):
            out[c, p] = 0.0
        for i in range(first.shape[0]):
            for j in range(nodes):
                total[0, j] = 0.0
                total[1, j] = 0.0
            for m in range(STENCIL):
                row = first[i] + m
                reference_waves(row_omega[row], slowness[c], row_beta[row], distance, -1.0, term[0], term[1])
                for j in range(nodes):
                    a = weight[i, m] * value[row, 2 * j]
                    b = weight[i, m] * value[row, 2 * j + 1]
                    total[0, j] += a * term[0, j] - b * term[1, j]
                    total[1, j] += a * term[1, j] + b * term[0, j]
            reference_waves(omega[i], slowness[c], beta[i], distance, 1.0, term[0], term[1])
            for j in range(nodes):
                a = total[0, j] * term[0, j] - total[1, j] * term[1, j]
                b = total[0, j] * term[1, j] + total[1, j] * term[0, j]
                real = a * force[i, 2 * j] - b * force[i, 2 * j + 1] - direct[i, 2 * j]
                imag = a * force[i, 2 * j + 1] + b * force[i, 2 * j] - direct[i, 2 * j + 1]
                term[0, j] = (real * real + imag * imag) / (size[i, j] * size[i, j])
            for p in range(out.shape[1]):
                for j in range(order * p, order * (p + 1)):
                    out[c, p] = max(out[c, p], term[0, j])
    return np.sqrt(out)
