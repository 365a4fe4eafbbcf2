"""Gauss–Legendre panels: functions of wavenumber that are known at the nodes of panels.

A function on a panel [c − h, c + h] is known at `ORDER` Gauss–Legendre nodes, that is as the polynomial
through these.
"""

import numpy as np
from numpy.polynomial import legendre

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
"""Weights of the nodes from weights of the powers: rows powers, columns nodes."""
BARYCENTRIC = np.array([1.0 / np.prod(node - np.delete(NODE, i)) for i, node in enumerate(NODE)])
"""Barycentric weights of the nodes."""


def nodes_between(edge: np.ndarray) -> np.ndarray:
    """Return the nodes of the panels between ascending edges (…, panels + 1), shape (…, panels × order)."""
    middle = 0.5 * (edge[..., 1:] + edge[..., :-1])
    half = 0.5 * (edge[..., 1:] - edge[..., :-1])
    return np.asarray((middle[..., None] + half[..., None] * NODE).reshape(*edge.shape[:-1], -1))


def to_legendre(value: np.ndarray) -> np.ndarray:
    """Return the Legendre coefficients of functions at the nodes of panels, (…, order)."""
    return np.asarray(value @ TO_LEGENDRE.T)


def series_tails(value: np.ndarray) -> np.ndarray:
    """Return the larger of the last two Legendre coefficients of panels (…, panels × order), (…, panels).

    It tells how well a panel resolves a function.
    """
    last = value.reshape(*value.shape[:-1], -1, ORDER) @ TO_LEGENDRE[-2:].T
    return np.asarray(np.abs(last).max(axis=-1))
