"""Moments of the full model's excitation over the panels of the tables' wavenumbers.

The moments of a panel of |κ| are ∫ |A(κ + shift)|² xⁿ dκ over both sides, κ > 0 and κ < 0, with x from −1 to
1 on the panel. A is a polynomial on panels of |β| = |κ + shift|. The two kinds of panels cut each other into
parts, each of which has a few Gauss–Legendre nodes, one for each number in a vector register.
"""

import numpy as np

from railvib.numerics.intrinsics import square_moments
from railvib.numerics.jit import fused_kernel, inline, reduction_kernel
from railvib.numerics.wavenumber_panels import ORDER

_NODES = 8
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(_NODES)
"""Nodes of a part: fewer than a panel's, as a part is small against one of its two panels."""
_LONGEST_PART = 1.25
"""Largest sum of a part's shares in its panels of κ and β for which these nodes resolve the integrand."""
_add_square_moments = square_moments(ORDER, _NODE.tolist(), _WEIGHT.tolist())


@fused_kernel
def moments(edge, wanted, shift, parts, rows, beta_edge, lowest, highest, out):
    """Write the moments of panels that are wanted, (lines, panels, order).

    Parameters
    ----------
    edge
        The panels' edges, (lines, panels + 1), rad/m.
    wanted
        Whether the moments of each panel are wanted, (lines, panels).
    shift
        2πf/v, (lines,), rad/m.
    parts, rows
        What `Excitation.amplitude_parts` returns, in powers of x on the excitation's panels, and which of its
        lines these are.
    beta_edge
        Edges of the excitation's panels, rad/m.
    lowest, highest
        Limits of |κ + shift|, rad/m, beyond which there is no excitation.
    out
        Where the moments are written; other panels are left unchanged.
    """
    lines, panels = wanted.shape
    terms = parts.shape[3]
    plane = parts.shape[2] * terms
    tiny = 1e-12 * beta_edge[-1]
    sums = np.empty((ORDER, _NODES))
    below = np.empty(2, np.int64)
    over_width = np.empty(beta_edge.shape[0] - 1)
    for b in range(over_width.shape[0]):
        over_width[b] = 1.0 / (beta_edge[b + 1] - beta_edge[b])
    for i in range(lines):
        below[0] = 0
        below[1] = 0
        for p in range(panels):
            if not wanted[i, p]:
                continue
            low = edge[i, p]
            high = edge[i, p + 1]
            over = 1.0 / (high - low)
            for n in range(ORDER):
                for j in range(_NODES):
                    sums[n, j] = 0.0
            for k in range(2):
                side = 2.0 * k - 1.0
                start = low
                while high - start > tiny:
                    b, backward, end, below[k] = _excited_panel(
                        beta_edge, start, side, shift[i], tiny, below[k]
                    )
                    if b >= beta_edge.shape[0] - 1:
                        start = end  # beyond the last edge there is no excitation
                        continue
                    if end > high - tiny:
                        end = high
                    scale = 2.0 * over_width[b]
                    if (end - start) * (0.5 * scale + over) > _LONGEST_PART:
                        end = 0.5 * (start + end)
                    centre = 0.5 * (start + end)
                    half = 0.5 * (end - start)
                    start = end
                    beta = side * centre + shift[i]
                    if not lowest <= abs(beta) <= highest:
                        continue
                    # Where the part's nodes lie on the panels of β and of κ: offset and slope.
                    place = (
                        (abs(beta) - beta_edge[b]) * scale - 1.0,
                        (-side if backward else side) * half * scale,
                        2.0 * (centre - low) * over - 1.0,
                        2.0 * half * over,
                        half,
                        # At −β the q_l are conjugate.
                        -1.0 if backward else 1.0,
                    )
                    _add_square_moments(parts, rows[i] * terms + b * ORDER, plane, place, sums)
            _sum_nodes(sums, out[i, p])


@reduction_kernel
def _sum_nodes(sums, out):
    """Write the sums over nodes."""
    for n in range(ORDER):
        total = 0.0
        for j in range(_NODES):
            total += sums[n, j]
        out[n] = total


@inline
def _excited_panel(edge, kappa, side, shift, tiny, below):
    """Return the panel of |β| on which the part from |κ| on lies, whether β < 0 there, and where it ends.

    The fourth value is the number of edges below, where the next search begins: parts follow one another.
    """
    beta = side * kappa + shift
    if side > 0.0:
        n = _count_below(edge, beta + tiny, below)
        return n - 1, False, (edge[n] - shift if n < edge.shape[0] else np.inf), n
    if beta > tiny:  # towards β = 0
        n = _count_below(edge, beta - tiny, below)
        return n - 1, False, shift - edge[n - 1], n
    n = _count_below(edge, -beta + tiny, below)
    return n - 1, True, (edge[n] + shift if n < edge.shape[0] else np.inf), n


@inline
def _count_below(edge, limit, guess):
    """Return how many ascending edges are below a limit, from a guess."""
    n = guess
    while n < edge.shape[0] and edge[n] < limit:
        n += 1
    while n > 0 and edge[n - 1] >= limit:
        n -= 1
    return n
