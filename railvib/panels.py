"""Gauss–Legendre panels: values at the nodes of a panel, and what can be done with them exactly or nearly so.

A function on a panel [c − h, c + h] is known at `ORDER` Gauss–Legendre nodes. Its Fourier integrals ∫ f
e^{iβd} dβ are sums over the nodes where few oscillations fit into the panel, and Legendre series times
spherical Bessel functions where many do (Filon): ∫ P_n(t) e^{iθt} dt = 2 iⁿ j_n(θ).
"""

from math import comb

import numba
import numpy as np
from scipy.special import eval_legendre, roots_legendre

from railvib.blocks import STENCIL
from railvib.vector_math import cos_sin

ORDER = 12
"""Nodes of a panel."""
NODE, WEIGHT = roots_legendre(ORDER)
TO_LEGENDRE = np.array([eval_legendre(n, NODE) * WEIGHT * (2 * n + 1) / 2 for n in range(ORDER)])
"""Legendre coefficients from the values at a panel's nodes: rows n, columns nodes."""
BARYCENTRIC = np.array([1.0 / np.prod(each - np.delete(NODE, i)) for i, each in enumerate(NODE)])
"""Barycentric weights of the nodes."""
_MOST_PHASE = 8.0
"""Half a panel's phase up to which the sum over its nodes is used: there its error is below 1e-9."""


def nodes_between(edge: np.ndarray) -> np.ndarray:
    """Return the nodes of the panels between ascending edges (…, panels + 1), shape (…, panels × order)."""
    middle = 0.5 * (edge[..., 1:] + edge[..., :-1])
    half = 0.5 * (edge[..., 1:] - edge[..., :-1])
    return np.asarray((middle[..., None] + half[..., None] * NODE).reshape(*edge.shape[:-1], -1))


def unresolved(value: np.ndarray) -> np.ndarray:
    """Return the size of the last Legendre coefficients of panels (…, panels × order), shape (…, panels)."""
    coefficient = value.reshape(*value.shape[:-1], -1, ORDER) @ TO_LEGENDRE.T
    return np.asarray(np.abs(coefficient[..., -2:]).max(axis=-1))


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
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
    """
    distances = distance.shape[0]
    c = np.empty(distances)
    s = np.empty(distances)
    coefficient = np.empty((value.shape[0], ORDER))
    bessel = np.empty(ORDER + 40)
    for p in range(centre.shape[0]):
        h = half[p]
        near = np.searchsorted(distance, _MOST_PHASE / h)
        # The innermost loops run over distances, so that they fill vector registers.
        for j in range(ORDER):
            beta = centre[p] + h * NODE[j]
            for k in range(near):
                c[k], s[k] = cos_sin(beta * distance[k])
            for q in range(value.shape[0]):
                weighted = h * WEIGHT[j] * value[q, p, j]
                for k in range(near):
                    cosine[q, k] += weighted * c[k]
                    sine[q, k] += weighted * s[k]
        if near < distances:
            for q in range(value.shape[0]):
                for n in range(ORDER):
                    total = 0.0
                    for j in range(ORDER):
                        total += TO_LEGENDRE[n, j] * value[q, p, j]
                    coefficient[q, n] = total
        for k in range(near, distances):
            spherical_bessel(h * distance[k], ORDER, bessel)
            cc, ss = cos_sin(centre[p] * distance[k])
            for q in range(value.shape[0]):
                even = 0.0
                odd = 0.0
                sign = 2.0 * h
                for n in range(0, ORDER, 2):
                    even += sign * bessel[n] * coefficient[q, n]
                    odd += sign * bessel[n + 1] * coefficient[q, n + 1]
                    sign = -sign
                cosine[q, k] += cc * even - ss * odd
                sine[q, k] += ss * even + cc * odd


@numba.njit(cache=True, error_model="numpy")
def spherical_bessel(x, order, out):
    """Write j_0(x) … j_{order−1}(x), x ≥ 0, to `out`, at least 40 longer: upward where stable, else down."""
    if x < 1e-8:
        out[0] = 1.0
        for n in range(1, order):
            out[n] = out[n - 1] * x / (2.0 * n + 1.0)
        return
    j0 = np.sin(x) / x
    j1 = (j0 - np.cos(x)) / x
    if x > order:
        out[0] = j0
        out[1] = j1
        for n in range(1, order - 1):
            out[n + 1] = (2.0 * n + 1.0) / x * out[n] - out[n - 1]
        return
    top = order + 30
    out[top + 1] = 0.0
    out[top] = 1e-280
    for n in range(top, 0, -1):
        out[n - 1] = (2.0 * n + 1.0) / x * out[n] - out[n + 1]
        if abs(out[n - 1]) > 1e250:
            for m in range(n - 1, top + 2):
                out[m] *= 1e-250
    scale = j0 / out[0] if abs(j0) > abs(j1) else j1 / out[1]
    for n in range(order):
        out[n] *= scale


@numba.njit(cache=True, error_model="numpy")
def panel_weights(x, weight):
    """Write the weights of a panel's nodes for interpolation at x in [−1, 1] (barycentric form)."""
    total = 0.0
    for j in range(ORDER):
        d = x - NODE[j]
        if d == 0.0:
            weight[:] = 0.0
            weight[j] = 1.0
            return
        weight[j] = BARYCENTRIC[j] / d
        total += weight[j]
    for j in range(ORDER):
        weight[j] /= total


_BINOMIAL = np.array([(-1.0) ** m * comb(STENCIL - 1, m) for m in range(STENCIL)])


@numba.njit(cache=True, error_model="numpy")
def stencil_weights(t, weight):
    """Write the weights of equidistant points 0, 1, … for interpolation at t (barycentric form)."""
    nearest = round(t)
    if abs(t - nearest) < 1e-12 and 0 <= nearest < STENCIL:
        weight[:] = 0.0
        weight[int(nearest)] = 1.0
        return
    total = 0.0
    for m in range(STENCIL):
        weight[m] = _BINOMIAL[m] / (t - m)
        total += weight[m]
    for m in range(STENCIL):
        weight[m] /= total


@numba.njit(inline="always", error_model="numpy")
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
