"""Exponential, sine and cosine, complex root and reciprocal that a compiler can vectorise.

The library functions are called one value at a time, which costs more than everything else in the kernels of
this project. These are straight-line polynomials: Cody–Waite range reduction, then minimax or Taylor
polynomials, within 2 units in the last place over the ranges stated. They contain no branch, so a loop that
calls them runs in vector registers. A caller must not allow the compiler to reassociate sums: rounding to an
integer rests on adding and subtracting a large number.
"""

import numpy as np

from railvib.numerics.intrinsics import bits, double
from railvib.numerics.jit import fused_kernel, inline

MAGIC = 6755399441055744.0  # 1.5·2^52: adding it leaves the nearest integer in the low bits of the sum
LOG2E = 1.4426950408889634
LN2_HIGH = 0.693147180369123816490
LN2_LOW = 1.90821492927058770002e-10
TWO_OVER_PI = 0.6366197723675814
HALF_PI_1 = 1.57079632673412561417
HALF_PI_2 = 6.07710050630396597660e-11
HALF_PI_3 = 2.02226624879595063154e-21
ONE_BITS = 0x3FF0000000000000
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
MAGIC_BITS = 0x4338000000000000
LANES = 64
"""Values that go through a longer recursion together, so that its innermost loops fill vector registers."""


@inline
def exp(x: float) -> float:
    """Return e^x for −700 < x < 700."""
    t = x * LOG2E + MAGIC
    n = t - MAGIC
    r = (x - n * LN2_HIGH) - n * LN2_LOW
    p = 1.0 / 6227020800.0
    p = p * r + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    p = p * r + 1.0
    p = p * r + 1.0
    power: float = double((bits(t) << np.int64(52)) + np.int64(ONE_BITS))
    return p * power


@inline
def log(x: float) -> float:
    """Return ln x of a normal x > 0."""
    pattern = bits(x)
    # The exponent that leaves a factor between √½ and √2, by the bits of √½; then ln m = 2 artanh s.
    up = (pattern - np.int64(ROOT_HALF_BITS)) >> np.int64(52)
    m: float = double(pattern - (up << np.int64(52)))
    n: float = double(up + np.int64(MAGIC_BITS)) - MAGIC
    s = (m - 1.0) / (m + 1.0)
    z = s * s
    p = 1.0 / 21.0
    p = p * z + 1.0 / 19.0
    p = p * z + 1.0 / 17.0
    p = p * z + 1.0 / 15.0
    p = p * z + 1.0 / 13.0
    p = p * z + 1.0 / 11.0
    p = p * z + 1.0 / 9.0
    p = p * z + 1.0 / 7.0
    p = p * z + 1.0 / 5.0
    p = p * z + 1.0 / 3.0
    return n * LN2_HIGH + (n * LN2_LOW + 2.0 * (s + s * z * p))


@inline
def cos_sin(x: float) -> tuple[float, float]:
    """Return (cos x, sin x) for abs(x) < 1e6."""
    t = x * TWO_OVER_PI + MAGIC
    n = t - MAGIC
    q = bits(t)
    r = ((x - n * HALF_PI_1) - n * HALF_PI_2) - n * HALF_PI_3
    z = r * r
    s = 1.58962301576546568060e-10
    s = s * z - 2.50507477628578072866e-8
    s = s * z + 2.75573136213857245213e-6
    s = s * z - 1.98412698295895385996e-4
    s = s * z + 8.33333333332211858878e-3
    s = s * z - 1.66666666666666307295e-1
    s = r + r * z * s
    c = -1.13585365213876817300e-11
    c = c * z + 2.08757008419747316778e-9
    c = c * z - 2.75573141792967388112e-7
    c = c * z + 2.48015872888517045348e-5
    c = c * z - 1.38888888888730564116e-3
    c = c * z + 4.16666666666665929218e-2
    c = 1.0 - 0.5 * z + z * z * c
    odd = (q & np.int64(1)) != 0
    cosine = s if odd else c
    sine = c if odd else s
    # The signs of cosine and sine follow from the quadrant, moved into the sign bits.
    cosine = double(bits(cosine) ^ (((q + np.int64(1)) & np.int64(2)) << np.int64(62)))
    sine = double(bits(sine) ^ ((q & np.int64(2)) << np.int64(62)))
    return cosine, sine


@inline
def exp2_cispi(x: float, y: float) -> tuple[float, float]:
    """Return real and imaginary part of 2^x·e^{iπy} for x < 1000, abs(y) < 1e6; x is cut at −1000.

    With r and s what is left of x and y beyond the nearest integers, 2^r = (a + b)/(a − b) with
    b/a = tanh(r ln 2/2), and e^{iπs} = (c + id)²/(c² + d²) with d/c = tan(πs/2): one division for both, and
    fewer operations than polynomials take. The coefficients interpolate at Chebyshev points in r² and s².
    """
    x = x if x > -1000.0 else -1000.0
    n = x + MAGIC
    r = x - (n - MAGIC)
    z = r * r
    a = (z + 233.1777519752325) * z + 4368.078795177389
    b = r * ((0.023094399453830353 * z + 20.2016706494636) * z + 1513.860750670445)
    m = y + MAGIC
    s = y - (m - MAGIC)
    z = s * s
    c = ((z - 45.3922434567228) * z + 363.78148069057767) * z - 319.38923760012096
    d = s * (((0.05638996615262831 * z - 8.56989178527574) * z + 158.79865238563065) * z - 501.6954412400925)
    size = (a + b) / ((a - b) * (c * c + d * d))
    # The power goes into the exponent; an odd number of half turns moves into the sign bit.
    size = double(bits(size) + (bits(n) << np.int64(52)) + (bits(m) << np.int64(63)))
    return size * (c * c - d * d), size * ((c + c) * d)


@inline
def rough_log2(x: float) -> float:
    """Return log2 of a normal x > 0, or up to 0.09 less: straight lines between powers of two."""
    return float(bits(x)) * 2.0**-52 - 1023.0


@inline
def reciprocal(z: complex) -> complex:
    """Return 1/z of a complex z without the branches of a general division; |z|² must not overflow."""
    scale = 1.0 / (z.real * z.real + z.imag * z.imag)
    return complex(z.real * scale, -z.imag * scale)


@inline
def root(z: complex) -> complex:
    """Return the square root of a complex z with a real part that is not negative."""
    size = np.sqrt(z.real * z.real + z.imag * z.imag)
    big = np.sqrt(0.5 * (size + abs(z.real)))
    small = 0.5 * abs(z.imag) / max(big, 1e-300)
    real = big if z.real >= 0.0 else small
    imag = small if z.real >= 0.0 else big
    return complex(real, imag if z.imag >= 0.0 else -imag)


def phasors(angle: np.ndarray) -> np.ndarray:
    """Return e^{i·angle} of angles below 1e6; NumPy's complex exponential takes several times as long."""
    value = np.empty((*angle.shape, 2))
    _write_phasors(np.ascontiguousarray(angle, float).ravel(), value.ravel())
    return value.view(complex)[..., 0]


@fused_kernel
def _write_phasors(angle: np.ndarray, value: np.ndarray) -> None:
    """Write cosine and sine in turn."""
    for i in range(angle.shape[0]):
        value[2 * i], value[2 * i + 1] = cos_sin(angle[i])
