"""Boundary elements of the soil under the track: the ground's Green's functions integrated over strips.

The Green's functions of the layered half-space leave only the interface |y| ≤ b to be divided. Right of the
centre line lie strips on which each traction is constant; the load is symmetric, so left of it lie their
images, on which p_y has the other sign. Per strip the unknowns are the forces f_x, f_y, f_z per length of
track that the track exerts on it, and the averages of u_x, u_y, u_z over it. All fields vary as e^{iβx}; u_x
and f_x stand for u_x/i and f_x/i, which makes every matrix symmetric.
"""

import numpy as np

from railvib.fe_be._kernels import boundary_elements as kernels
from railvib.soil.tensor_fit import TensorFit

_GRADING = 2.5
"""Power with which strips shrink towards the edge, where tractions grow like 1/√distance."""


def graded_edges(half_width: float, elements: int) -> np.ndarray:
    """Return the edges 0 … b of strips that shrink towards y = b, m, (elements + 1,)."""
    return np.asarray(half_width * (1.0 - (1.0 - np.arange(elements + 1) / elements) ** _GRADING))


def strip_flexibility(fit: TensorFit, wavenumber: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """Return the average displacements of strips per force on strips, complex (n, 3m, 3m) [m²/N].

    Parameters
    ----------
    fit
        The ground's flexibility tensor, up to some 50 over the width of the smallest strip.
    wavenumber
        β along the track, (n,), rad/m.
    edge
        Edges of the strips right of the centre line, from 0 to half the contact width, (m + 1,), m.
        Unknowns are ordered x, y, z, and the strips inside.
    """
    return np.asarray(kernels.strip_flexibility(wavenumber, fit.pole, fit.residue, fit.constant, edge))


def receiver_flexibility(
    fit: TensorFit, wavenumber: np.ndarray, edge: np.ndarray, offset: np.ndarray
) -> np.ndarray:
    """Return the vertical displacements of receivers per force on strips, complex (n, receivers, 3m) [m²/N].

    Parameters
    ----------
    fit, wavenumber, edge
        As in `strip_flexibility`; away from the strips a fit up to usual wavenumbers is enough.
    offset
        Distances of receivers from the centre line, (receivers,), m, not negative.
    """
    return np.asarray(
        kernels.receiver_flexibility(wavenumber, fit.pole, fit.residue, fit.constant, edge, offset)
    )
