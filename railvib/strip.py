"""Compliance of the ground under a strip load, in closed form from the poles of its flexibility.

With Q33(ρ) ≈ d + Σ_j a_j/(ρ² − z_j), the Fourier integral over γ of CONVENTIONS (docs/conventions.md, section
2) is elementary. Symbols: beta wavenumber along the track, b half the contact width, y distance from the
centre line, k = √(β² − z) with Re k > 0. Per pole

    y ≥ b:  e^{−k(y−b)} (1 − e^{−2kb})/(4 b k²)        y < b:  [2 − e^{−k(b+y)} − e^{−k(b−y)}]/(4 b k²)

and the constant d contributes d/(2b) inside the strip only.
"""

import numba
import numpy as np

from railvib.vector_math import cos_sin, exp

CLIP = 150.0
"""Exponents beyond this are cut: e^{−150} is nothing here, and denormal numbers would cost time."""


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def strip_compliances(beta, pole, residue, constant, b, offset):
    """Return real and imaginary part of C(β, y) at one frequency, each (offsets, wavenumbers) [m²/N].

    Parameters
    ----------
    beta
        Wavenumbers along the track, float (n,), rad/m.
    pole, residue, constant
        Rational form of Q33: complex (p,), complex (p,), complex.
    b
        Half the contact width, m.
    offset
        Distances from the centre line, float (m,), m, not negative.
    """
    n = beta.shape[0]
    m = offset.shape[0]
    real = np.zeros((m, n))
    imag = np.zeros((m, n))
    kr = np.empty(n)
    ki = np.empty(n)
    gr = np.empty(n)
    gi = np.empty(n)
    cr = np.empty(n)
    ci = np.empty(n)
    for j in range(pole.shape[0]):
        zr = pole[j].real
        zi = pole[j].imag
        ar = residue[j].real / (4.0 * b)
        ai = residue[j].imag / (4.0 * b)
        for i in range(n):
            wr = beta[i] * beta[i] - zr
            wi = -zi
            big = np.sqrt(0.5 * (np.sqrt(wr * wr + wi * wi) + abs(wr)))
            small = 0.5 * abs(wi) / big
            positive = wr >= 0.0
            kr[i] = big if positive else small
            x = small if positive else big
            ki[i] = x if wi >= 0.0 else -x
            # a/(4 b k²), with k² = w
            s = 1.0 / (wr * wr + wi * wi)
            gr[i] = (ar * wr + ai * wi) * s
            gi[i] = (ai * wr - ar * wi) * s
            # 1 − e^{−2kb}
            e = exp(-min(2.0 * b * kr[i], CLIP))
            c, t = cos_sin(2.0 * b * ki[i])
            hr = 1.0 - e * c
            hi = e * t
            cr[i] = gr[i] * hr - gi[i] * hi
            ci[i] = gr[i] * hi + gi[i] * hr
        for k in range(m):
            y = offset[k]
            if y >= b:
                # From some wavenumber on, or all together, nothing is left of the wave.
                last = n
                while last > 0 and (y - b) * kr[last - 1] > CLIP:
                    last -= 1
                for i in range(last):
                    e = exp(-min((y - b) * kr[i], CLIP))
                    c, t = cos_sin((y - b) * ki[i])
                    real[k, i] += e * (cr[i] * c + ci[i] * t)
                    imag[k, i] += e * (ci[i] * c - cr[i] * t)
            else:
                for i in range(n):
                    e = exp(-min((b - y) * kr[i], CLIP))
                    c, t = cos_sin((b - y) * ki[i])
                    f = exp(-min((b + y) * kr[i], CLIP))
                    d, u = cos_sin((b + y) * ki[i])
                    hr = 2.0 - e * c - f * d
                    hi = e * t + f * u
                    real[k, i] += gr[i] * hr - gi[i] * hi
                    imag[k, i] += gr[i] * hi + gi[i] * hr
    for k in range(m):
        if offset[k] < b:
            for i in range(n):  # as one statement on rows this would take Numba two seconds more to compile
                real[k, i] += constant.real / (2.0 * b)
                imag[k, i] += constant.imag / (2.0 * b)
    return real, imag


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def products(real, imag, factor, out):
    """Write rows of complex numbers times a row of complex factors, real and imaginary parts in turn."""
    for i in range(real.shape[0]):
        for j in range(real.shape[1]):
            out[i, 2 * j] = real[i, j] * factor[j].real - imag[i, j] * factor[j].imag
            out[i, 2 * j + 1] = real[i, j] * factor[j].imag + imag[i, j] * factor[j].real
