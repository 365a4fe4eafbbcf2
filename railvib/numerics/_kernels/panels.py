"""Fourier integrals over panels of wavenumbers.

They are sums over the nodes where few oscillations fit into a panel, and Legendre series times spherical
Bessel functions where many do (Filon): ∫ P_n(t) e^{iθt} dt = 2 iⁿ j_n(θ).
"""

import numpy as np

from railvib.numerics.jit import fused_kernel, inline
from railvib.numerics.vector_math import cos_sin
from railvib.numerics.wavenumber_panels import NODE, ORDER, TO_LEGENDRE, WEIGHT

_MOST_PHASE = 8.0
"""Half a panel's phase up to which the sum over its nodes is used: there its error is below 1e-9."""


@inline
def count_below(ascending, limit):
    """Return how many of ascending values are below a limit."""
    low = 0
    high = ascending.shape[0]
    while low < high:
        middle = (low + high) // 2
        if ascending[middle] < limit:
            low = middle + 1
        else:
            high = middle
    return low


@fused_kernel
def fourier_integrals(centre, half, value, distance, cosine, sine):
    """Add ∫ f cos(βd) dβ and ∫ f sin(βd) dβ over panels to `cosine` and `sine`.

    Parameters
    ----------
    centre, half
        The panels, (panels,).
    value
        Real functions at the nodes, (functions, panels, order).
    distance
        d, not negative and ascending, (distances,).
    cosine, sine
        Where the integrals are added, (functions, distances).

    Notes
    -----
    The nodes lie symmetrically about a panel's centre, so even and odd parts of a function need cosines and
    sines at half of them, and these depend on the panel's width alone. The innermost loops run over
    distances, so that they fill vector registers.
    """
    distances = distance.shape[0]
    pairs = ORDER // 2
    c = np.empty(distances)
    s = np.empty(distances)
    even = np.empty(distances)
    odd = np.empty(distances)
    basis = np.empty((ORDER, distances))
    near = 0
    width = -1.0
    for p in range(centre.shape[0]):
        h = half[p]
        if abs(h - width) > 1e-13 * h:
            width = h
            near = count_below(distance, _MOST_PHASE / h)
            for j in range(pairs):
                _cosines_and_sines(h * NODE[pairs + j], distance[:near], basis[2 * j], basis[2 * j + 1])
            _spherical_bessel(h, distance[near:], basis[:, near:])
        _cosines_and_sines(centre[p], distance, c, s)
        for q in range(value.shape[0]):
            for k in range(distances):
                even[k] = 0.0
                odd[k] = 0.0
            for j in range(pairs):
                up = value[q, p, pairs + j]
                down = value[q, p, pairs - 1 - j]
                a = h * WEIGHT[pairs + j] * (up + down)
                b = h * WEIGHT[pairs + j] * (up - down)
                for k in range(near):
                    even[k] += a * basis[2 * j, k]
                    odd[k] += b * basis[2 * j + 1, k]
            if near < distances:
                sign = 2.0 * h
                for n in range(0, ORDER, 2):
                    a = 0.0
                    b = 0.0
                    for j in range(ORDER):
                        a += sign * TO_LEGENDRE[n, j] * value[q, p, j]
                        b += sign * TO_LEGENDRE[n + 1, j] * value[q, p, j]
                    for k in range(near, distances):
                        even[k] += a * basis[n, k]
                        odd[k] += b * basis[n + 1, k]
                    sign = -sign
            for k in range(distances):
                cosine[q, k] += c[k] * even[k] - s[k] * odd[k]
            for k in range(distances):
                sine[q, k] += s[k] * even[k] + c[k] * odd[k]


@fused_kernel
def _cosines_and_sines(beta, distance, cosine, sine):
    """Write cos(βd) and sin(βd)."""
    for k in range(distance.shape[0]):
        cosine[k], sine[k] = cos_sin(beta * distance[k])


@fused_kernel
def _spherical_bessel(h, distance, out):
    """Write j_0(hd) … j_{order−1}(hd), hd ≥ 8, where the upward recurrence is stable for these orders."""
    for k in range(distance.shape[0]):
        x = h * distance[k]
        c, s = cos_sin(x)
        below = s / x
        j = (below - c) / x
        out[0, k] = below
        out[1, k] = j
        for n in range(1, ORDER - 1):
            above = (2.0 * n + 1.0) / x * j - below
            out[n + 1, k] = above
            below = j
            j = above
