"""Gauss–Legendre panels: values at the nodes of a panel, and what can be done with them exactly or nearly so.

A function on a panel [c − h, c + h] is known at `ORDER` Gauss–Legendre nodes. Its Fourier integrals ∫ f
e^{iβd} dβ are sums over the nodes where few oscillations fit into the panel, and Legendre series times
spherical Bessel functions where many do (Filon): ∫ P_n(t) e^{iθt} dt = 2 iⁿ j_n(θ).
"""

import numpy as np
from numpy.polynomial import legendre

from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.jit import fused_kernel, inline
from railvib.numerics.vector_math import cos_sin

ORDER = 12
"""Nodes of a panel."""
NODE, WEIGHT = legendre.leggauss(ORDER)
TO_LEGENDRE = legendre.legvander(NODE, ORDER - 1).T * WEIGHT * (np.arange(ORDER) + 0.5)[:, None]
"""Legendre coefficients from the values at a panel's nodes: rows n, columns nodes."""
TO_POWERS = np.array(
    [np.pad(legendre.leg2poly(row), (0, ORDER - 1 - n)) for n, row in enumerate(np.eye(ORDER))]
)
"""Coefficients of powers of x from Legendre coefficients: rows Legendre polynomials, columns powers."""
FROM_POWERS = TO_POWERS.T @ TO_LEGENDRE
"""What weights of the nodes follow from weights of the powers: rows powers, columns nodes."""
BARYCENTRIC = np.array([1.0 / np.prod(each - np.delete(NODE, i)) for i, each in enumerate(NODE)])
"""Barycentric weights of the nodes."""
_MOST_PHASE = 8.0
"""Half a panel's phase up to which the sum over its nodes is used: there its error is below 1e-9."""


def nodes_between(edge: np.ndarray) -> np.ndarray:
    """Return the nodes of the panels between ascending edges (…, panels + 1), shape (…, panels × order)."""
    middle = 0.5 * (edge[..., 1:] + edge[..., :-1])
    half = 0.5 * (edge[..., 1:] - edge[..., :-1])
    return np.asarray((middle[..., None] + half[..., None] * NODE).reshape(*edge.shape[:-1], -1))


def to_legendre(value: np.ndarray) -> np.ndarray:
    """Return the Legendre coefficients of functions at the nodes of panels, (…, order)."""
    return np.asarray(value @ TO_LEGENDRE.T)


def unresolved(value: np.ndarray) -> np.ndarray:
    """Return the size of the last Legendre coefficients of panels (…, panels × order), shape (…, panels)."""
    last = value.reshape(*value.shape[:-1], -1, ORDER) @ TO_LEGENDRE[-2:].T
    return np.asarray(np.abs(last).max(axis=-1))


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


@fused_kernel
def panel_weights(count, x, weight, room):
    """Write the weights of a panel's nodes for interpolation at `count` places x in [−1, 1].

    Parameters
    ----------
    count
        How many places.
    x
        The places, at least (count,).
    weight
        Where the weights are written, (order, at least count).
    room
        Room to work in, at least (count,).
    """
    _lagrange_products(count, x, NODE, BARYCENTRIC, weight, room)


_EQUIDISTANT = np.arange(STENCIL, dtype=float)
_OVER_DIFFERENCES = np.array(
    [1.0 / np.prod(each - np.delete(_EQUIDISTANT, i)) for i, each in enumerate(_EQUIDISTANT)]
)


@fused_kernel
def stencil_weights(count, t, weight, room):
    """Write the weights of equidistant points 0, 1, … for interpolation at places t, as `panel_weights`."""
    _lagrange_products(count, t, _EQUIDISTANT, _OVER_DIFFERENCES, weight, room)


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
