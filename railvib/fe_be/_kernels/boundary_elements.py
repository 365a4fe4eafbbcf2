"""Integrals of the ground's Green's functions over strips; see `railvib.fe_be.boundary_elements`.

With the rational form of `railvib.soil.tensor_fit` and κ = √(β² − z), each term of a part of the tensor is
e^{−κ|y|}/(2κ) across the track, and its integrals over strips are elementary:

    Φ'' = e^{−κ|y|}/(2κ),  Φ = (e^{−x} − 1 + x − x²/2)/(2κ³) + y²/(4κ),  x = κ|y|

The quadratic is integrated apart, and Φ by its series where x is small, so that nothing cancels.
"""

import numpy as np

from railvib.numerics.jit import inline, kernel

_EXPONENT = 60.0
"""Exponent of decay beyond which a wave is negligible."""
_SERIES = 0.3
"""Size of x below which series are used."""


@inline
def _even(x, k, decayed):
    """Return Φ without its quadratic for x = κ|y|, k = κ, given e^{−x}."""
    if abs(x) > _SERIES:
        return (decayed - 1.0 + x - 0.5 * x * x) / (2.0 * k * k * k)
    s = 1.0 - x / 7.0 * (1.0 - x / 8.0 * (1.0 - x / 9.0 * (1.0 - x / 10.0 * (1.0 - x / 11.0))))
    s = 1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * s))
    return -x * x * x / 12.0 * s / (k * k * k)


@inline
def _odd(x, k, decayed):
    """Return Φ' without its linear term for x = κy, y ≥ 0, given e^{−x}."""
    if abs(x) > _SERIES:
        return (1.0 - decayed - x) / (2.0 * k * k)
    s = 1.0 - x / 6.0 * (1.0 - x / 7.0 * (1.0 - x / 8.0 * (1.0 - x / 9.0 * (1.0 - x / 10.0))))
    s = 1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * s))
    return -0.25 * x * x * s / (k * k)


@kernel
def strip_flexibility(beta, pole, residue, constant, edge):
    """Return the average displacements of strips per force on strips, complex (n, 3m, 3m) [m²/N].

    `pole`, `residue` and `constant` are those of a `TensorFit`.
    """
    n = edge.shape[0] - 1
    width = edge[1:] - edge[:-1]
    flexibility = np.zeros((beta.shape[0], 3 * n, 3 * n), np.complex128)
    # Sums over the poles at differences (0) and sums (1) of two edges: xx, yy, zz, xz even; xy, yz odd.
    nodal = np.empty((6, 2, n + 1, n + 1), np.complex128)
    quadratic = np.empty(4, np.complex128)
    a = np.empty(6, np.complex128)
    step = np.empty(n, np.complex128)
    from_centre = np.empty(n + 1, np.complex128)
    for w in range(beta.shape[0]):
        b = beta[w]
        nodal[:] = 0.0
        quadratic[:] = 0.0
        for j in range(pole.shape[0]):
            k = np.sqrt(b * b - pole[j])
            zz, rr, tt, d, c = residue[0, j], residue[1, j], residue[2, j], residue[3, j], residue[4, j]
            a[0] = tt + b * b * d
            a[1] = rr - b * b * d
            a[2] = zz
            a[3] = b * c
            a[4] = -b * d
            a[5] = c
            for i in range(4):
                quadratic[i] += a[i] / (2.0 * k)
            from_centre[0] = 1.0
            for i in range(n):
                step[i] = np.exp(-k * width[i]) if k.real * width[i] < _EXPONENT else 0j
                from_centre[i + 1] = from_centre[i] * step[i]
            for i in range(n + 1):
                decayed = 1.0 + 0j
                for o in range(i, -1, -1):
                    x = k * (edge[i] - edge[o])
                    even, odd = _even(x, k, decayed), _odd(x, k, decayed)
                    for q in range(4):
                        nodal[q, 0, i, o] += a[q] * even
                    nodal[4, 0, i, o] += a[4] * odd
                    nodal[5, 0, i, o] += a[5] * odd
                    x = k * (edge[i] + edge[o])
                    together = from_centre[i] * from_centre[o]
                    even, odd = _even(x, k, together), _odd(x, k, together)
                    for q in range(4):
                        nodal[q, 1, i, o] += a[q] * even
                    nodal[4, 1, i, o] += a[4] * odd
                    nodal[5, 1, i, o] += a[5] * odd
                    if o > 0:
                        decayed *= step[o - 1]
        for i in range(n + 1):
            for o in range(i):
                nodal[:, 1, o, i] = nodal[:, 1, i, o]
                nodal[:4, 0, o, i] = nodal[:4, 0, i, o]
                nodal[4:, 0, o, i] = -nodal[4:, 0, i, o]
        for i in range(n):
            for o in range(n):
                area = width[i] * width[o]
                for q in range(6):
                    near = (
                        nodal[q, 0, i + 1, o]
                        - nodal[q, 0, i, o]
                        - nodal[q, 0, i + 1, o + 1]
                        + nodal[q, 0, i, o + 1]
                    ) / area
                    image = (
                        nodal[q, 1, i + 1, o + 1]
                        - nodal[q, 1, i, o + 1]
                        - nodal[q, 1, i + 1, o]
                        + nodal[q, 1, i, o]
                    ) / area
                    if q < 4:
                        near += quadratic[q]
                        image += quadratic[q]
                    if q == 0:
                        flexibility[w, i, o] = near + image
                    elif q == 1:
                        flexibility[w, n + i, n + o] = near - image
                    elif q == 2:
                        flexibility[w, 2 * n + i, 2 * n + o] = near + image
                    elif q == 3:
                        flexibility[w, i, 2 * n + o] = near + image
                        flexibility[w, 2 * n + o, i] = near + image
                    elif q == 4:  # u_x per p_y, whose images have the other sign
                        flexibility[w, i, n + o] = near - image
                        flexibility[w, n + o, i] = near - image
                    else:  # u_y per p_z
                        flexibility[w, n + i, 2 * n + o] = near + image
                        flexibility[w, 2 * n + o, n + i] = near + image
            # The constants act where they are loaded only.
            flexibility[w, i, i] += constant[2] / width[i]
            flexibility[w, n + i, n + i] += constant[1] / width[i]
            flexibility[w, 2 * n + i, 2 * n + i] += constant[0] / width[i]
    return flexibility


@kernel
def _decay(k, y):
    """Return e^{−ky}, 0 where it is negligible."""
    return np.exp(-k * y) if k.real * y < _EXPONENT else 0j


@kernel
def receiver_flexibility(beta, pole, residue, constant, edge, offset):
    """Return the vertical displacements of receivers per force on strips, complex (n, receivers, 3m) [m²/N].

    `pole`, `residue` and `constant` are those of a `TensorFit`.
    """
    n = edge.shape[0] - 1
    out = np.zeros((beta.shape[0], offset.shape[0], 3 * n), np.complex128)
    for w in range(beta.shape[0]):
        for j in range(pole.shape[0]):
            k = np.sqrt(beta[w] * beta[w] - pole[j])
            for r in range(offset.shape[0]):
                if k.real * (offset[r] - edge[n]) < _EXPONENT:
                    _add_receiver(out[w, r], offset[r], edge, k, beta[w], residue[:, j])
        for r in range(offset.shape[0]):
            for i in range(n):
                if edge[i] <= offset[r] < edge[i + 1]:
                    out[w, r, 2 * n + i] += constant[0] / (edge[i + 1] - edge[i])
    return out


@kernel
def _add_receiver(row, y, edge, k, beta, residue):
    """Add one pole's share of u_z at y per f_x, f_y, f_z on every strip and its image."""
    n = edge.shape[0] - 1
    scale = 1.0 / (2.0 * k)
    far = _decay(k, y + edge[0])
    near = _decay(k, abs(y - edge[0]))
    for i in range(n):
        next_far = _decay(k, y + edge[i + 1])
        next_near = _decay(k, abs(y - edge[i + 1]))
        if y >= edge[i + 1]:
            integral = next_near - near
        elif y <= edge[i]:
            integral = near - next_near
        else:
            integral = 2.0 - near - next_near
        width = edge[i + 1] - edge[i]
        even = (integral + far - next_far) * scale / k / width
        odd = (near - next_near - next_far + far) * scale / width
        row[i] += beta * residue[4] * even
        row[n + i] -= residue[4] * odd
        row[2 * n + i] += residue[0] * even
        far = next_far
        near = next_near
