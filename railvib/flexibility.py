"""Vertical flexibility Q33 of the ground's surface in the wavenumber domain, free of cancellation.

Symbols of the kernels: r horizontal wavenumber, p and s vertical wavenumbers of P and SV waves (Re >= 0), kp2
and ks2 squared wavenumbers of the waves, e = (c_s/c_p)², m complex shear modulus, h thickness, q 2 × 2
flexibility (displacements u_x, u_z per stresses τ_xz, σ_zz) at the current depth, looking down.

The textbook basis of P and SV waves becomes parallel where r is far above k_s, and digits are lost like
(r/k_s)². Here the second basis wave is (P − SV)/k_s², whose components are written with r − s = k_s²/(r + s)
and the like, so that nothing is subtracted; it propagates with a triangular 2 × 2 matrix of decaying
exponentials. See docs/theory/ground.md.
"""

import cmath

import numba
import numpy as np
import numpy.typing as npt

from railvib.errors import InputError
from railvib.ground import Ground


@numba.njit(cache=True, error_model="numpy", inline="always")
def _propagator_coupling(p, s, e, h, decay):
    """Return (e^{−ph} − e^{−sh})/k_s², given decay = e^{−sh}, without subtracting equals."""
    t = (p - s) * h
    if abs(t) < 0.05:
        g = 1.0 - t / 2.0 * (
            1.0 - t / 3.0 * (1.0 - t / 4.0 * (1.0 - t / 5.0 * (1.0 - t / 6.0 * (1.0 - t / 7.0))))
        )
        return -decay * h * (1.0 - e) / (p + s) * g
    return decay * (cmath.exp(-t) - 1.0) / t * h * (1.0 - e) / (p + s)


@numba.njit(cache=True, error_model="numpy")
def psv_flexibility(r, omega, stack, rigid):
    """Return q11, q12, q21, q22 of one wavenumber r, Re r ≥ 0, at omega ≥ 0 rad/s [m/Pa].

    Displacements ũ_r, u_z of the surface per stresses τ̃_rz, σ_zz on it, u_r = i ũ_r and τ_rz = i τ̃_rz along
    the wave vector; `stack` is that of `Ground`.
    """
    q11 = 0j
    q12 = 0j
    q21 = 0j
    q22 = 0j
    r2 = r * r
    last = stack.shape[0] - 1
    for layer in range(last, -1, -1):
        cs = stack[layer, 0]
        cp = stack[layer, 1]
        loss = 1.0 + 1j * stack[layer, 3] if omega > 0.0 else 1.0 + 0j
        m = stack[layer, 2] * cs * cs * loss
        h = stack[layer, 4]
        e = (cs / cp) ** 2
        ks2 = omega * omega / (cs * cs * loss)
        p = cmath.sqrt(r2 - e * ks2)
        s = cmath.sqrt(r2 - ks2)
        # Downgoing basis: columns P and (P − SV)/k_s²; the upgoing one has the signs of u_z and τ_xz
        # reversed.
        rs = 1.0 / (r + s)
        rp = e / (r + p)
        ux1 = r + 0j
        uz1 = -p
        tx1 = -2.0 * m * r * p
        tz1 = m * (2.0 * r2 - ks2)
        ux2 = rs
        uz2 = rp
        tx2 = m * (2.0 * r * rp - 1.0)
        tz2 = m * ks2 * rs * rs
        if layer == last and not rigid:
            m11 = 0j
            m12 = 0j
            m21 = 0j
            m22 = 0j
        else:
            # Upgoing amplitudes at the layer's bottom: b = −(U_u − q U_t)⁻¹ (D_u − q D_t) E a.
            a11 = ux1 - q11 * tx1 - q12 * tz1
            a12 = ux2 - q11 * tx2 - q12 * tz2
            a21 = uz1 - q21 * tx1 - q22 * tz1
            a22 = uz2 - q21 * tx2 - q22 * tz2
            b11 = ux1 + q11 * tx1 - q12 * tz1
            b12 = ux2 + q11 * tx2 - q12 * tz2
            b21 = -uz1 + q21 * tx1 - q22 * tz1
            b22 = -uz2 + q21 * tx2 - q22 * tz2
            d = -1.0 / (b11 * b22 - b12 * b21)
            g11 = d * (b22 * a11 - b12 * a21)
            g12 = d * (b22 * a12 - b12 * a22)
            g21 = d * (b11 * a21 - b21 * a11)
            g22 = d * (b11 * a22 - b21 * a12)
            # Reflection seen from the layer's top: M = E G E, E = [[ep, ec], [0, es]].
            ep = cmath.exp(-p * h)
            es = cmath.exp(-s * h)
            ec = _propagator_coupling(p, s, e, h, es)
            w11 = ep * g11 + ec * g21
            w12 = ep * g12 + ec * g22
            w21 = es * g21
            w22 = es * g22
            m11 = w11 * ep
            m12 = w11 * ec + w12 * es
            m21 = w21 * ep
            m22 = w21 * ec + w22 * es
        # Flexibility at the layer's top: q = (D_u + U_u M)(D_t + U_t M)⁻¹.
        u11 = ux1 + ux1 * m11 + ux2 * m21
        u12 = ux2 + ux1 * m12 + ux2 * m22
        u21 = uz1 - uz1 * m11 - uz2 * m21
        u22 = uz2 - uz1 * m12 - uz2 * m22
        t11 = tx1 - tx1 * m11 - tx2 * m21
        t12 = tx2 - tx1 * m12 - tx2 * m22
        t21 = tz1 + tz1 * m11 + tz2 * m21
        t22 = tz2 + tz1 * m12 + tz2 * m22
        d = 1.0 / (t11 * t22 - t12 * t21)
        q11 = d * (u11 * t22 - u12 * t21)
        q12 = d * (u12 * t11 - u11 * t12)
        q21 = d * (u21 * t22 - u22 * t21)
        q22 = d * (u22 * t11 - u21 * t12)
    return q11, q12, q21, q22


@numba.njit(cache=True, error_model="numpy")
def surface_flexibility(r, omega, stack, rigid):
    """Return Q33 of one wavenumber r, Re r ≥ 0, at omega ≥ 0 rad/s [m/Pa]; `stack` is that of `Ground`."""
    return -psv_flexibility(r, omega, stack, rigid)[3]


@numba.njit(cache=True, error_model="numpy")
def surface_flexibilities(r, omega, stack, rigid):
    """Return Q33 of many wavenumbers r (n,), all at one frequency, as a complex array (n,)."""
    q = np.empty(r.shape[0], np.complex128)
    for i in range(r.shape[0]):
        q[i] = surface_flexibility(r[i], omega, stack, rigid)
    return q


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
        here = np.abs(f) == value
        q[here] = surface_flexibilities(np.ascontiguousarray(r[here]), 2.0 * np.pi * value, stack, rigid)
    return np.where(f < 0.0, q.conj(), q)[()]
