"""The ground's flexibility by stiffness matrices of its layers, in plain NumPy, as most codes do it.

Exact stiffness matrices of Kausel and Roësset (1981), in the form of Kausel, Fundamental Solutions in
Elastodynamics (2006), section 10.3: p = √(1 − (ω/kα)²), s = √(1 − (ω/kβ)²), hyperbolic functions C and S of
kph and ksh. They are scaled by their growing exponentials, so that thick layers do not overflow. All
wavenumbers go through every step together.
"""

import numpy as np

from railvib.parameters.ground import Ground


def by_linear_algebra(ground: Ground, wavenumber: np.ndarray, omega: float) -> np.ndarray:
    """Return Q33 at positive wavenumbers (n,) from assembled matrices (n, dofs, dofs), m/Pa."""
    matrices, base = _layers(ground, wavenumber, omega)
    dofs = 2 * (len(matrices) + (base is not None))
    stiffness = np.zeros((wavenumber.size, dofs, dofs), complex)
    for i, matrix in enumerate(matrices):
        size = min(4, dofs - 2 * i)  # on rigid bedrock the last interface is fixed
        stiffness[:, 2 * i : 2 * i + size, 2 * i : 2 * i + size] += matrix[:, :size, :size]
    if base is not None:
        stiffness[:, -2:, -2:] += base
    load = np.zeros((dofs, 1))
    load[1] = 1.0
    return np.asarray(np.linalg.solve(stiffness, load)[:, 1, 0])


def by_elimination(ground: Ground, wavenumber: np.ndarray, omega: float) -> np.ndarray:
    """Return Q33 with the interfaces eliminated from below by 2 × 2 inverses in closed form."""
    matrices, base = _layers(ground, wavenumber, omega)
    below = base
    for matrix in reversed(matrices):
        upper = matrix[:, :2, :2]
        if below is not None:
            inverse = _inverse(matrix[:, 2:, 2:] + below)
            upper = upper - matrix[:, :2, 2:] @ inverse @ matrix[:, 2:, :2]
        below = upper
    assert below is not None
    return np.asarray(_inverse(below)[:, 1, 1])


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverses of 2 × 2 matrices (n, 2, 2)."""
    out = np.empty_like(matrix)
    out[:, 0, 0], out[:, 1, 1] = matrix[:, 1, 1], matrix[:, 0, 0]
    out[:, 0, 1], out[:, 1, 0] = -matrix[:, 0, 1], -matrix[:, 1, 0]
    out /= (matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0])[:, None, None]
    return out


def _layers(ground: Ground, k: np.ndarray, omega: float) -> tuple[list[np.ndarray], np.ndarray | None]:
    """Return the layers' matrices (n, 4, 4) from the surface down, and the half-space's (n, 2, 2)."""
    matrices: list[np.ndarray] = []
    base = None
    for layer in ground.layers:
        loss = 1.0 + 1j * layer.loss_factor
        modulus = layer.shear_modulus * loss
        p = np.sqrt(1.0 - (omega / (k * layer.dilatational_speed)) ** 2 / loss)
        s = np.sqrt(1.0 - (omega / (k * layer.shear_speed)) ** 2 / loss)
        if layer.thickness is None:
            base = _half_space(k, modulus, p, s)
        else:
            matrices.append(_layer(k, modulus, p, s, layer.thickness))
    return matrices, base


def _layer(k: np.ndarray, modulus: complex, p: np.ndarray, s: np.ndarray, h: float) -> np.ndarray:
    """Return the stiffness matrices of a layer, degrees of freedom u_x, u_z above, then below."""
    ep, es = np.exp(-k * p * h), np.exp(-k * s * h)
    both = ep * es
    cp, sp = 0.5 * (1.0 + ep * ep), 0.5 * (1.0 - ep * ep)
    cs, ss = 0.5 * (1.0 + es * es), 0.5 * (1.0 - es * es)
    ps, s2 = p * s, s * s
    # Numerators and denominator are divided by e^{k(p + s)h}.
    common = (1.0 - s2) / (2.0 * (both - cp * cs) + (1.0 / ps + ps) * sp * ss) / 2.0
    off = common * (both - cp * cs + ps * sp * ss) + 0.5 * (1.0 + s2)
    across = common * (cp * es - cs * ep)
    out = np.empty((k.size, 4, 4), complex)
    out[:, 0, 0] = out[:, 2, 2] = common * (cp * ss - ps * cs * sp) / s
    out[:, 1, 1] = out[:, 3, 3] = common * (cs * sp - ps * cp * ss) / p
    out[:, 0, 1] = out[:, 1, 0] = -off
    out[:, 2, 3] = out[:, 3, 2] = off
    out[:, 0, 2] = out[:, 2, 0] = common * (ps * sp * es - ss * ep) / s
    out[:, 1, 3] = out[:, 3, 1] = common * (ps * ss * ep - sp * es) / p
    out[:, 0, 3] = out[:, 3, 0] = -across
    out[:, 1, 2] = out[:, 2, 1] = across
    out *= (2.0 * k * modulus)[:, None, None]
    return out


def _half_space(k: np.ndarray, modulus: complex, p: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return the stiffness matrices of the half-space below."""
    common = (1.0 - s * s) / (2.0 * (1.0 - p * s))
    out = np.empty((k.size, 2, 2), complex)
    out[:, 0, 0], out[:, 1, 1] = common * p, common * s
    out[:, 0, 1] = out[:, 1, 0] = common - 1.0
    out *= (2.0 * k * modulus)[:, None, None]
    return out
