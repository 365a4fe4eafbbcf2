"""Flexibility of the ground's surface for stresses in all three directions, in the wavenumber domain.

A horizontal wave vector (β, γ) of length ρ decouples the surface: along it and downwards move P and SV waves,
across it SH waves. With e_r = (β, γ)/ρ and e_t = (−γ, β)/ρ,

    u_r = q_rr p_r + q_rz p_z        u_z = −q_rz p_r + q_zz p_z        u_t = q_tt p_t

for stresses p on the surface, positive along x, y and downwards. All follow from functions of ρ² that are
smooth at ρ = 0: q_zz (which is Q33), q_rr, q_tt, q_d = (q_rr − q_tt)/ρ² and q_c = q_rz/(iρ),

    Q_xx = q_tt + β² q_d    Q_xy = βγ q_d    Q_yy = q_tt + γ² q_d    Q_xz = iβ q_c    Q_yz = iγ q_c

with Q_zx = −Q_xz and Q_zy = −Q_yz. See docs/theory/ground.md.
"""

import numpy as np
import numpy.typing as npt

from railvib.errors import InputError
from railvib.parameters.ground import Ground
from railvib.soil._kernels.layers import RR, RZ, TT, ZZ, surface_components


def ground_flexibility_tensor(
    ground: Ground, wavenumber_x: npt.ArrayLike, wavenumber_y: npt.ArrayLike, frequency: npt.ArrayLike
) -> np.ndarray:
    """Return the surface's displacements per unit surface stresses, all nine.

    Parameters
    ----------
    ground
        The layered ground.
    wavenumber_x, wavenumber_y
        β along the track and γ across it, rad/m.
    frequency
        Frequency, Hz; negative values give what real signals need, zero the undamped static value. The three
        broadcast.

    Returns
    -------
    ndarray of complex, shape (…, 3, 3)
        m/Pa: the displacement along the axis of the row per stress along the axis of the column, in the order
        x, y, z with z downward.

    Raises
    ------
    InputError
        If both wavenumbers and the frequency are zero on a half-space.

    Notes
    -----
    P-SV by the recursion of `ground_flexibility`, SH by that of Haskell (1953) in hyperbolic tangents.
    Q(β, γ, −ω) is the conjugate of Q(−β, −γ, ω).
    """
    beta, gamma, f = np.broadcast_arrays(
        np.asarray(wavenumber_x, float), np.asarray(wavenumber_y, float), np.asarray(frequency, float)
    )
    r = np.hypot(beta, gamma)
    if ground.base == "half-space" and np.any((r == 0.0) & (f == 0.0)):
        raise InputError("wavenumbers and frequency are all 0: a half-space yields without bound")
    stack = ground.stack()
    q = np.empty((4, *r.shape), complex)
    for value in np.unique(np.abs(f)):
        part = np.abs(f) == value
        omega = 2.0 * np.pi * float(value)
        q[:, part] = surface_components(r[part], omega, stack, ground.base == "rigid")
    q = np.where(f < 0.0, q.conj(), q)
    with np.errstate(invalid="ignore"):
        c, s = np.where(r > 0.0, beta / r, 1.0), np.where(r > 0.0, gamma / r, 0.0)
    tensor = np.empty((*r.shape, 3, 3), complex)
    tensor[..., 0, 0] = c * c * q[RR] + s * s * q[TT]
    tensor[..., 1, 1] = s * s * q[RR] + c * c * q[TT]
    tensor[..., 0, 1] = tensor[..., 1, 0] = c * s * (q[RR] - q[TT])
    tensor[..., 2, 2] = q[ZZ]
    for axis, share in enumerate((c, s)):
        tensor[..., axis, 2] = 1j * share * q[RZ]
        tensor[..., 2, axis] = -1j * share * q[RZ]
    return tensor
