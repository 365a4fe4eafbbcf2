"""The closed form of the compliance of the ground under a strip load.

With Q33(ρ) ≈ d + Σ_j a_j/(ρ² − z_j), the Fourier integral over γ in docs/conventions.md is elementary.
Symbols: beta wavenumber along the track, b half the contact width, y distance from the
centre line, k = √(β² − z) with Re k > 0. Per pole

    y ≥ b:  e^{−k(y−b)} (1 − e^{−2kb})/(4 b k²)        y < b:  [2 − e^{−k(b+y)} − e^{−k(b−y)}]/(4 b k²)

and the constant d contributes d/(2b) inside the strip and d/(4b) at its very edge. The mean of C(β, y) over
the strip has per pole

    [1 − (1 − e^{−2kb})/(2kb)]/(2 b k²)

and d/(2b).

Beyond the strip most poles count nothing beside the wave that is damped least. So at every wavenumber each
pole has a reach, the distance from the strip beyond which its wave is passed over, as it is less than
2^−NEGLIGIBLE of the one that is strongest FAR away. This holds at all greater distances, because only waves
that decay faster than that one are passed over.
"""

import numpy as np

from railvib.numerics.jit import fused_kernel, inline
from railvib.numerics.vector_math import exp2_cispi, rough_log2

STRETCH = 32
"""Wavenumbers that are taken together: all poles' values at them stay in a near cache."""
NEGLIGIBLE = 54.0
"""Halvings below another wave at which a wave is passed over: 6e-17 of it."""
CLIP = 216.0
"""Halvings at which nothing is left of any wave: e^−150."""
FAR = 30.0
"""Distance from the strip in m at which the strongest wave is the one that the others are compared with."""
LOG2E = 1.4426950408889634
HALF_TURN = 0.3183098861837907  # 1/π
SMALL = 0.01
"""|2kb|² below which 1 − (1 − e^{−2kb})/(2kb) is taken from its series, as it would lose digits."""
POWER, PHASE, INSIDE_REAL, INSIDE_IMAG, BEYOND_REAL, BEYOND_IMAG, REACH = range(7)
"""Rows per pole: doublings and half turns of e^{−k} per m; what stands before the exponentials inside the
strip and beyond it; distance in m, and before it is known the logarithm of what stands before."""
SQUARE, STRONGEST, DECAY, CENTRE_REAL, CENTRE_IMAG, TOTAL_REAL, TOTAL_IMAG = range(7)
"""Rows of the sum: β²; logarithm and doublings per m of the strongest wave; C(β, 0); C(β, y)."""
ROWS = 7


@fused_kernel
def strip_compliances(beta, pole, residue, constant, b, offset):
    """Return real and imaginary part of C(β, y) at one frequency, each (offsets, wavenumbers) [m²/N].

    A value depends on its own wavenumber and offset only, not on what else is asked for.

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
    p = pole.shape[0]
    real = np.empty((offset.shape[0], n))
    imag = np.empty((offset.shape[0], n))
    wave = np.empty((p, ROWS, STRETCH))
    farthest = np.empty(p)
    at = np.empty((ROWS, STRETCH))
    quarter = 0.25 / b
    for stretch in range((n + STRETCH - 1) // STRETCH):
        first = stretch * STRETCH
        count = n - first if n - first < STRETCH else STRETCH
        for i in range(STRETCH):
            # The last stretch is filled up with its first wavenumber.
            wavenumber = beta[first + (i if i < count else 0)]
            at[SQUARE, i] = wavenumber * wavenumber
            at[STRONGEST, i] = -1e300
            at[DECAY, i] = 0.0
            at[CENTRE_REAL, i] = 0.0
            at[CENTRE_IMAG, i] = 0.0
        for j in range(p):
            zr = pole[j].real
            wi = -pole[j].imag
            ar = -quarter * residue[j].real
            ai = -quarter * residue[j].imag
            turn = HALF_TURN if wi < 0.0 else -HALF_TURN
            for i in range(STRETCH):
                # The root of k² = w, with one division for it and for 1/k².
                wr = at[SQUARE, i] - zr
                size = wr * wr + wi * wi
                big = np.sqrt(0.5 * (np.sqrt(size) + abs(wr)))
                inverse = 1.0 / (size * big)
                small = 0.5 * abs(wi) * (size * inverse)
                wave[j, POWER, i] = -LOG2E * (big if wr >= 0.0 else small)
                wave[j, PHASE, i] = turn * (small if wr >= 0.0 else big)
                # −a/(4 b k²)
                inverse = inverse * big
                wave[j, INSIDE_REAL, i] = (ar * wr + ai * wi) * inverse
                wave[j, INSIDE_IMAG, i] = (ai * wr - ar * wi) * inverse
            for i in range(STRETCH):
                power = wave[j, POWER, i]
                gr = wave[j, INSIDE_REAL, i]
                gi = wave[j, INSIDE_IMAG, i]
                er, ei = exp2_cispi(b * power, b * wave[j, PHASE, i])
                # a/(4 b k²) (1 − e^{−kb}), twice of which is C(β, 0), and that times 1 + e^{−kb}
                hr = gr * er - gi * ei - gr
                hi = gr * ei + gi * er - gi
                cr = hr + hr * er - hi * ei
                ci = hi + hr * ei + hi * er
                at[CENTRE_REAL, i] += 2.0 * hr
                at[CENTRE_IMAG, i] += 2.0 * hi
                wave[j, BEYOND_REAL, i] = cr
                wave[j, BEYOND_IMAG, i] = ci
                strength = 0.5 * rough_log2(cr * cr + ci * ci)
                wave[j, REACH, i] = strength
                strongest = at[STRONGEST, i]
                decay = at[DECAY, i]
                stronger = strength + FAR * power > strongest + FAR * decay
                at[STRONGEST, i] = strength if stronger else strongest
                at[DECAY, i] = power if stronger else decay
        for j in range(p):
            for i in range(STRETCH):
                # To where it is negligible beside the strongest wave, or nothing at all if that is nearer.
                power = wave[j, POWER, i]
                left = wave[j, REACH, i] - at[STRONGEST, i] + NEGLIGIBLE
                left = left if left > 0.0 else 0.0
                loss = at[DECAY, i] - power
                beside = -left * power < CLIP * loss
                wave[j, REACH, i] = (left if beside else CLIP) / (loss if beside else -power)
            farthest[j] = 0.0
            for i in range(STRETCH):
                reach = wave[j, REACH, i]
                farthest[j] = reach if reach > farthest[j] else farthest[j]
        for k in range(offset.shape[0]):
            y = offset[k]
            beyond = y >= b
            # Inside the strip none is passed over, and e^{−kd} − 1 from both edges stands in for e^{−kd}.
            before = BEYOND_REAL if beyond else INSIDE_REAL
            less = 0.0 if beyond else 1.0
            for i in range(STRETCH):
                at[TOTAL_REAL, i] = 0.0
                at[TOTAL_IMAG, i] = 0.0
            for side in range(1 if beyond else (0 if y == 0.0 else 2)):
                d = y + b if side == 1 else abs(y - b)
                travelled = d if beyond else 0.0
                for j in range(p):
                    if travelled > farthest[j]:
                        continue
                    for i in range(STRETCH):
                        er, ei = exp2_cispi(d * wave[j, POWER, i], d * wave[j, PHASE, i])
                        heard = travelled <= wave[j, REACH, i]
                        er = (er if heard else 0.0) - less
                        ei = ei if heard else 0.0
                        cr = wave[j, before, i]
                        ci = wave[j, before + 1, i]
                        at[TOTAL_REAL, i] = at[TOTAL_REAL, i] + cr * er - ci * ei
                        at[TOTAL_IMAG, i] = at[TOTAL_IMAG, i] + cr * ei + ci * er
            compliance = CENTRE_REAL if y == 0.0 else TOTAL_REAL
            # The transform of a constant over the strip takes the mean of both sides at its edge.
            inside = 0.5 if y == b else less
            for i in range(count):
                real[k, first + i] = at[compliance, i] + inside * (0.5 / b) * constant.real
                imag[k, first + i] = at[compliance + 1, i] + inside * (0.5 / b) * constant.imag
    return real, imag


@fused_kernel
def strip_means(beta, pole, residue, constant, b):
    """Return real and imaginary part of the mean of C(β, y) over the strip, each (wavenumbers,) [m²/N].

    Parameters
    ----------
    beta, pole, residue, constant, b
        As in `strip_compliances`.
    """
    n = beta.shape[0]
    real = np.empty(n)
    imag = np.empty(n)
    total = np.empty((2, STRETCH))
    square = np.empty(STRETCH)
    share = np.empty((2, STRETCH))
    before = np.empty((2, STRETCH))
    half = 0.5 / b
    for stretch in range((n + STRETCH - 1) // STRETCH):
        first = stretch * STRETCH
        count = n - first if n - first < STRETCH else STRETCH
        for i in range(STRETCH):
            # The last stretch is filled up with its first wavenumber.
            wavenumber = beta[first + (i if i < count else 0)]
            square[i] = wavenumber * wavenumber
            total[0, i] = half * constant.real
            total[1, i] = half * constant.imag
        for j in range(pole.shape[0]):
            zr = pole[j].real
            wi = -pole[j].imag
            ar = half * residue[j].real
            ai = half * residue[j].imag
            nearest = 1e300
            for i in range(STRETCH):
                # The root of k² = w, with one division for it, for 1/k² and for 1/k.
                wr = square[i] - zr
                size = wr * wr + wi * wi
                modulus = np.sqrt(size)
                big = np.sqrt(0.5 * (modulus + abs(wr)))
                inverse = 1.0 / (size * big)
                small = 0.5 * abs(wi) * (size * inverse)
                inverse = inverse * big
                kr = big if wr >= 0.0 else small
                ki = small if wr >= 0.0 else big
                ki = -ki if wi < 0.0 else ki
                er, ei = exp2_cispi(-2.0 * b * LOG2E * kr, -2.0 * b * HALF_TURN * ki)
                # 1 − (1 − e^{−2kb})/(2kb)
                scale = half * modulus * inverse
                share[0, i] = 1.0 - scale * ((1.0 - er) * kr - ei * ki)
                share[1, i] = scale * ((1.0 - er) * ki + ei * kr)
                # a/(2 b k²)
                before[0, i] = (ar * wr + ai * wi) * inverse
                before[1, i] = (ai * wr - ar * wi) * inverse
            for i in range(STRETCH):
                near = abs(square[i] - zr)
                nearest = near if near < nearest else nearest
            if 4.0 * b * b * max(nearest, abs(wi)) < SMALL:
                for i in range(STRETCH):
                    square_of_argument = 4.0 * b * b * complex(square[i] - zr, wi)
                    if abs(square_of_argument) < SMALL:
                        series = _share_of_small(np.sqrt(square_of_argument))
                        share[0, i] = series.real
                        share[1, i] = series.imag
            for i in range(STRETCH):
                total[0, i] += before[0, i] * share[0, i] - before[1, i] * share[1, i]
                total[1, i] += before[0, i] * share[1, i] + before[1, i] * share[0, i]
        for i in range(count):
            real[first + i] = total[0, i]
            imag[first + i] = total[1, i]
    return real, imag


@inline
def _share_of_small(x):
    """Return 1 − (1 − e^{−x})/x of a small x; the next term is 3e-13 of it."""
    series = 1.0 / 5040.0 - x / 40320.0
    series = 1.0 / 720.0 - x * series
    series = 1.0 / 120.0 - x * series
    series = 1.0 / 24.0 - x * series
    series = 1.0 / 6.0 - x * series
    return x * (0.5 - x * series)
