"""The secular function of Rayleigh waves, which is zero at every mode and has no poles.

Dunkin (1965) and Watson (1970): the 2 × 2 minors of the conditions at the base are carried up through the
layers, five numbers instead of six, in a form that does not subtract equal exponentials. Symbols: k
horizontal wavenumber, p and s vertical wavenumbers of P and SV waves, gamma = 2 k²/k_s².
"""

import numpy as np

from railvib.numerics.jit import kernel


@kernel
def log_secular(k, base_p, base_s, omega, stack, rigid):
    """Return the logarithm of the secular function at complex wavenumbers (n,), its phase in any turn.

    Parameters
    ----------
    k
        Horizontal wavenumbers, rad/m.
    base_p, base_s
        Vertical wavenumbers in the half-space, which choose its sheet; not used over a rigid base.
    omega
        Angular frequency, rad/s, positive.
    stack, rigid
        The layers as of `Ground.stack`, and whether they lie on rigid bedrock.
    """
    out = np.empty(k.shape[0], np.complex128)
    minors = np.empty(5, np.complex128)
    last = stack.shape[0] - (0 if rigid else 1)
    for i in range(k.shape[0]):
        k2 = k[i] * k[i]
        if rigid:
            minors[:] = 0.0
            minors[0] = 1.0
        else:
            _at_half_space(k2, base_p[i], base_s[i], omega, stack[last], minors)
        logarithm = 0j
        for layer in range(last - 1, -1, -1):
            logarithm += _through_layer(k2, omega, stack[layer], minors)
            largest = np.abs(minors).max()
            minors /= largest
            logarithm += np.log(largest)
        out[i] = logarithm + np.log(minors[0])
    return out


@kernel
def _at_half_space(k2, p, s, omega, layer, minors):
    """Write the minors of the condition that nothing comes from below."""
    squared_ratio = 2.0 * layer[0] ** 2 * complex(1.0, layer[3]) / omega**2  # 2/k_s²
    gamma = k2 * squared_ratio
    density = layer[2]
    minors[0] = density**2 * ((gamma - 1.0) ** 2 - gamma * squared_ratio * p * s)
    minors[1] = -density * p
    minors[2] = density * (gamma - 1.0 - squared_ratio * p * s)
    minors[3] = density * s
    minors[4] = k2 - p * s
    minors /= np.abs(minors).max()


@kernel
def _hyperbolic(square, thickness):
    """Return e^{−v} times cosh v, sinh v/q and q sinh v, then v = qh and e^{−v}; q² is given, Re q ≥ 0."""
    q = np.sqrt(square)
    v = q * thickness
    decay = np.exp(-v)
    cosine = 0.5 * (1.0 + decay * decay)
    if abs(v) < 0.1:
        v2 = v * v
        over = decay * thickness * (1.0 + v2 / 6.0 * (1.0 + v2 / 20.0 * (1.0 + v2 / 42.0)))
    else:
        over = 0.5 * (1.0 - decay * decay) / q
    return cosine, over, over * square, v, decay


@kernel
def _through_layer(k2, omega, layer, minors):
    """Carry minors from a layer's bottom to its top over e^{(p+s)h}, and return (p + s)h."""
    loss = complex(1.0, layer[3])
    squared_ratio = 2.0 * layer[0] ** 2 * loss / omega**2
    cp, w, x, p_h, p_decay = _hyperbolic(k2 - omega**2 / (layer[1] ** 2 * loss), layer[4])
    cq, y, z, s_h, s_decay = _hyperbolic(k2 - omega**2 / (layer[0] ** 2 * loss), layer[4])
    rho = layer[2]
    g = k2 * squared_ratio
    gk = squared_ratio
    h = g - 1.0
    one = p_decay * s_decay
    cc = cp * cq
    rest = one - cc
    xz, wy = x * z, w * y
    a00 = cc - 2.0 * g * h * rest - g * gk * xz - k2 * h * h * wy
    a01 = (k2 * cp * y - cq * x) / rho
    a02 = -((g + h) * rest + gk * xz + k2 * h * wy) / rho
    a03 = (cp * z - k2 * cq * w) / rho
    a04 = -(2.0 * k2 * rest + xz + k2 * k2 * wy) / rho**2
    a10 = (g * gk * cp * z - h * h * cq * w) * rho
    a12 = gk * cp * z - h * cq * w
    a13 = -w * z
    a30 = (h * h * cp * y - g * gk * cq * x) * rho
    a31 = -x * y
    a32 = h * cp * y - gk * cq * x
    a40 = -(2.0 * g * gk * h * h * rest + (g * gk) ** 2 * xz + h**4 * wy) * rho**2
    a42 = -(gk * h * (g + h) * rest + g * gk * gk * xz + h**3 * wy) * rho
    t = -2.0 * k2
    m0, m1, m2, m3, m4 = minors
    minors[0] = m0 * a00 + m1 * a10 + m2 * t * a42 + m3 * a30 + m4 * a40
    minors[1] = m0 * a01 + m1 * cc + m2 * t * a32 + m3 * a31 + m4 * a30
    minors[2] = m0 * a02 + m1 * a12 + m2 * (one + 2.0 * (cc - a00)) + m3 * a32 + m4 * a42
    minors[3] = m0 * a03 + m1 * a13 + m2 * t * a12 + m3 * cc + m4 * a10
    minors[4] = m0 * a04 + m1 * a03 + m2 * t * a02 + m3 * a01 + m4 * a00
    return p_h + s_h
