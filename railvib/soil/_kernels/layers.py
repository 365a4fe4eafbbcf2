"""Flexibility of the layered ground's surface in the wavenumber domain, free of cancellation.

Symbols: r horizontal wavenumber, p and s vertical wavenumbers of P and SV waves (Re >= 0), kp2
and ks2 squared wavenumbers of the waves, e = (c_s/c_p)², m complex shear modulus, h thickness, q 2 × 2
flexibility (displacements u_x, u_z per stresses τ_xz, σ_zz) at the current depth, looking down.

The textbook basis of P and SV waves becomes parallel where r is far above k_s, and digits are lost like
(r/k_s)². Here the second basis wave is (P − SV)/k_s², whose components are written with r − s = k_s²/(r + s)
and the like, so that nothing is subtracted; it propagates with a triangular 2 × 2 matrix of decaying
exponentials. SH waves go by tanh. See docs/theory/ground.md.
"""

import cmath

import numpy as np

from railvib.numerics.jit import fused_kernel, inline, kernel
from railvib.numerics.vector_math import LANES, cos_sin, exp, reciprocal, root

ZZ, RR, TT, RZ = range(4)
"""Columns of `surface_components`."""


@inline
def _decay(k, h):
    """Return e^{−kh}, Re k ≥ 0."""
    size = exp(-min(k.real * h, 350.0))
    c, s = cos_sin(k.imag * h)
    return complex(size * c, -size * s)


@inline
def _waves(r, e, m, ks2):
    """Return p, s and the downgoing basis of waves P and (P − SV)/k_s²: u_x, u_z, τ_xz, σ_zz of each."""
    r2 = r * r
    p = root(r2 - e * ks2)
    s = root(r2 - ks2)
    rs = reciprocal(r + s)
    rp = e * reciprocal(r + p)
    p_wave = (r, -p, -2.0 * m * (r * p), m * (2.0 * r2 - ks2))
    difference = (rs, rp, m * (2.0 * r * rp - 1.0), m * ks2 * (rs * rs))
    return p, s, p_wave, difference


@inline
def _quotient(u11, u12, u21, u22, t11, t12, t21, t22):
    """Return the matrix U T⁻¹."""
    d = reciprocal(t11 * t22 - t12 * t21)
    return (
        d * (u11 * t22 - u12 * t21),
        d * (u12 * t11 - u11 * t12),
        d * (u21 * t22 - u22 * t21),
        d * (u22 * t11 - u21 * t12),
    )


@inline
def _half_space(r, e, m, ks2):
    """Return the flexibility of a half-space's surface."""
    _p, _s, (ux1, uz1, tx1, tz1), (ux2, uz2, tx2, tz2) = _waves(r, e, m, ks2)
    return _quotient(ux1, ux2, uz1, uz2, tx1, tx2, tz1, tz2)


@inline
def _propagator_coupling(p, s, e, h, ep, es):
    """Return (e^{−ph} − e^{−sh})/k_s², given both decays, without subtracting equals."""
    t = (p - s) * h
    series = 1.0 - t / 2.0 * (
        1.0 - t / 3.0 * (1.0 - t / 4.0 * (1.0 - t / 5.0 * (1.0 - t / 6.0 * (1.0 - t / 7.0))))
    )
    near = -es * series
    # Both are computed and one is chosen, since lanes cannot branch; the tiny number keeps t = 0 finite.
    far = (ep - es) * reciprocal(t + 1e-150)
    is_near = t.real * t.real + t.imag * t.imag < 0.05**2
    quotient = complex(near.real if is_near else far.real, near.imag if is_near else far.imag)
    return quotient * (h * (1.0 - e) * reciprocal(p + s))


@inline
def _layer(q11, q12, q21, q22, r, e, m, ks2, h):
    """Return the flexibility at a layer's top from that at its bottom."""
    p, s, (ux1, uz1, tx1, tz1), (ux2, uz2, tx2, tz2) = _waves(r, e, m, ks2)
    # The upgoing basis has the signs of u_z and τ_xz reversed. Upgoing amplitudes at the layer's bottom:
    # b = −(U_u − q U_t)⁻¹ (D_u − q D_t) E a.
    a11 = ux1 - q11 * tx1 - q12 * tz1
    a12 = ux2 - q11 * tx2 - q12 * tz2
    a21 = uz1 - q21 * tx1 - q22 * tz1
    a22 = uz2 - q21 * tx2 - q22 * tz2
    b11 = ux1 + q11 * tx1 - q12 * tz1
    b12 = ux2 + q11 * tx2 - q12 * tz2
    b21 = -uz1 + q21 * tx1 - q22 * tz1
    b22 = -uz2 + q21 * tx2 - q22 * tz2
    d = -reciprocal(b11 * b22 - b12 * b21)
    g11 = d * (b22 * a11 - b12 * a21)
    g12 = d * (b22 * a12 - b12 * a22)
    g21 = d * (b11 * a21 - b21 * a11)
    g22 = d * (b11 * a22 - b21 * a12)
    # Reflection seen from the layer's top: M = E G E, E = [[ep, ec], [0, es]].
    ep = _decay(p, h)
    es = _decay(s, h)
    ec = _propagator_coupling(p, s, e, h, ep, es)
    w11 = ep * g11 + ec * g21
    w12 = ep * g12 + ec * g22
    w21 = es * g21
    w22 = es * g22
    m11 = w11 * ep
    m12 = w11 * ec + w12 * es
    m21 = w21 * ep
    m22 = w21 * ec + w22 * es
    # Flexibility at the layer's top: q = (D_u + U_u M)(D_t + U_t M)⁻¹.
    return _quotient(
        ux1 + ux1 * m11 + ux2 * m21,
        ux2 + ux1 * m12 + ux2 * m22,
        uz1 - uz1 * m11 - uz2 * m21,
        uz2 - uz1 * m12 - uz2 * m22,
        tx1 - tx1 * m11 - tx2 * m21,
        tx2 - tx1 * m12 - tx2 * m22,
        tz1 + tz1 * m11 + tz2 * m21,
        tz2 + tz1 * m12 + tz2 * m22,
    )


@inline
def _material(stack, layer, omega):
    """Return e, m, k_s² and h of a layer."""
    cs = stack[layer, 0]
    loss = complex(1.0, stack[layer, 3] if omega > 0.0 else 0.0)
    e = (cs / stack[layer, 1]) ** 2
    return e, stack[layer, 2] * cs * cs * loss, omega * omega / (cs * cs * loss), stack[layer, 4]


@kernel
def psv_flexibility(r, omega, stack, rigid):
    """Return q11, q12, q21, q22 of one wavenumber r, Re r ≥ 0, at omega ≥ 0 rad/s [m/Pa].

    Displacements ũ_r, u_z of the surface per stresses τ̃_rz, σ_zz on it, u_r = i ũ_r and τ_rz = i τ̃_rz along
    the wave vector; `stack` is that of `Ground`.
    """
    q11 = 0j
    q12 = 0j
    q21 = 0j
    q22 = 0j
    last = stack.shape[0] - 1
    for layer in range(last, -1, -1):
        e, m, ks2, h = _material(stack, layer, omega)
        if layer == last and not rigid:
            q11, q12, q21, q22 = _half_space(r + 0j, e, m, ks2)
        else:
            q11, q12, q21, q22 = _layer(q11, q12, q21, q22, r + 0j, e, m, ks2, h)
    return q11, q12, q21, q22


@kernel
def surface_flexibility(r, omega, stack, rigid):
    """Return Q33 of one wavenumber r, Re r ≥ 0, at omega ≥ 0 rad/s [m/Pa]; `stack` is that of `Ground`."""
    return -psv_flexibility(r, omega, stack, rigid)[3]


@kernel
def complex_flexibilities(r, omega, stack, rigid):
    """Return Q33 of many complex wavenumbers r (n,), one by one: lanes of them are not worth compiling."""
    out = np.empty(r.shape[0], np.complex128)
    for i in range(r.shape[0]):
        out[i] = surface_flexibility(r[i], omega, stack, rigid)
    return out


@fused_kernel
def surface_flexibilities(r, omega, stack, rigid):
    """Return Q33 of many real wavenumbers r (n,), all at one frequency, as a complex array (n,)."""
    out = np.empty(r.shape[0], np.complex128)
    q = np.empty(8 * LANES)
    for first in range(0, r.shape[0], LANES):
        lanes = r[first : first + LANES]
        _through_layers(lanes, omega, stack, rigid, q)
        for i in range(lanes.shape[0]):
            out[first + i] = complex(-q[6 * LANES + i], -q[7 * LANES + i])
    return out


@fused_kernel
def _through_layers(r, omega, stack, rigid, q):
    """Write the surface flexibility of up to LANES wavenumbers to `q`, parts of q11, q12, q21, q22."""
    n = min(r.shape[0], LANES)
    last = stack.shape[0] - 1
    q[:] = 0.0
    for layer in range(last, -1, -1):
        e, m, ks2, h = _material(stack, layer, omega)
        if layer == last and not rigid:
            for i in range(n):
                _write_lane(q, i, _half_space(r[i], e, m, ks2))
        else:
            for i in range(n):
                q11 = complex(q[i], q[LANES + i])
                q12 = complex(q[2 * LANES + i], q[3 * LANES + i])
                q21 = complex(q[4 * LANES + i], q[5 * LANES + i])
                q22 = complex(q[6 * LANES + i], q[7 * LANES + i])
                _write_lane(q, i, _layer(q11, q12, q21, q22, r[i], e, m, ks2, h))


@inline
def _write_lane(q, i, flexibility):
    """Write the four entries of a flexibility to lane i."""
    q11, q12, q21, q22 = flexibility
    q[i] = q11.real
    q[LANES + i] = q11.imag
    q[2 * LANES + i] = q12.real
    q[3 * LANES + i] = q12.imag
    q[4 * LANES + i] = q21.real
    q[5 * LANES + i] = q21.imag
    q[6 * LANES + i] = q22.real
    q[7 * LANES + i] = q22.imag


@kernel
def sh_flexibility(r, omega, stack, rigid):
    """Return q_tt of one wavenumber r, Re r ≥ 0, at omega ≥ 0 rad/s [m/Pa]; `stack` is that of `Ground`."""
    q = 0j  # displacement per stress on the top of what lies below
    last = stack.shape[0] - 1
    for layer in range(last, -1, -1):
        cs = stack[layer, 0]
        loss = 1.0 + 1j * stack[layer, 3] if omega > 0.0 else 1.0 + 0j
        m = stack[layer, 2] * cs * cs * loss
        s = cmath.sqrt(r * r - omega * omega / (cs * cs * loss))
        if layer == last and not rigid:
            q = 1.0 / (m * s)
            continue
        # tanh(sh)/s, also where s vanishes.
        h = stack[layer, 4]
        x = s * h
        if abs(x) < 1e-3:
            t = h * (1.0 - x * x / 3.0 * (1.0 - 0.4 * x * x))
        else:
            e = cmath.exp(-2.0 * x)
            t = (1.0 - e) / (1.0 + e) / s
        q = (q + t / m) / (1.0 + q * m * s * s * t)
    return q


@kernel
def surface_components(r, omega, stack, rigid):
    """Return q_zz, q_rr, q_tt and q_rz/i of many wavenumbers r (n,), all at one frequency, as (4, n)."""
    out = np.empty((4, r.shape[0]), np.complex128)
    for i in range(r.shape[0]):
        q11, q12, q21, q22 = psv_flexibility(r[i], omega, stack, rigid)
        out[ZZ, i] = -q22
        out[RR, i] = -q11
        out[TT, i] = sh_flexibility(r[i], omega, stack, rigid)
        # Equal by reciprocity; their mean loses no digit.
        out[RZ, i] = -0.5 * (q12 + q21)
    return out
