"""Vertical flexibility Q33 of the ground's surface in the wavenumber domain."""

import numpy as np
import numpy.typing as npt

from railvib.errors import InputError
from railvib.parameters.ground import Ground
from railvib.soil._kernels.layers import surface_flexibilities


def ground_flexibility(ground: Ground, wavenumber: npt.ArrayLike, frequency: npt.ArrayLike) -> np.ndarray:
    """Return the vertical surface displacement per unit vertical surface stress, Q33.

    Parameters
    ----------
    ground
        The layered ground.
    wavenumber
        Horizontal wavenumber ρ = √(β² + γ²), rad/m; any sign, any shape that broadcasts with `frequency`.
    frequency
        Frequency, Hz; negative values give the conjugate, zero the undamped static value.

    Returns
    -------
    ndarray of complex
        Q33 in m/Pa, of the broadcast shape.

    Raises
    ------
    InputError
        If wavenumber and frequency are both zero on a half-space.

    Notes
    -----
    Flexibility-matrix approach of Sheng, Jones and Petyt (1999); the recursion is this project's own.
    """
    r, f = np.broadcast_arrays(np.abs(np.asarray(wavenumber, float)), np.asarray(frequency, float))
    if ground.base == "half-space" and np.any((r == 0.0) & (f == 0.0)):
        raise InputError("wavenumber and frequency are both 0: a half-space yields without bound")
    stack = ground.stack()
    rigid = ground.base == "rigid"
    q = np.empty(r.shape, complex)
    for value in np.unique(np.abs(f)):
        part = np.abs(f) == value
        q[part] = surface_flexibilities(np.ascontiguousarray(r[part]), 2.0 * np.pi * value, stack, rigid)
    return np.where(f < 0.0, q.conj(), q)[()]
