"""The equations of the axles of a train, coupled by vehicles and rail, at many frequencies.

    (Σ_T + Σ_R + I/k_H) P = −w̃        (Eq. 12)

Frequencies are taken some at a time, side by side in vector registers, through an elimination that leaves the
rows in their order. Receptances that dissipate allow that; the growth of numbers at each frequency shows
whether it was allowed.

Matrices are arrays (axles, axles + sets, lanes) of real and imaginary parts, with the unevenness behind them.
"""

import numpy as np

from railvib.numerics.intrinsics import row_subtraction
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import reciprocal

_LANES = 32
"""Frequencies side by side: the matrices of a train of sixteen axles then stay near the core."""
_subtract_row = row_subtraction(_LANES)


@fused_kernel
def solve(receptance, column, flexibility, first_term, term, share, contact, unevenness, forces):
    """Write the forces, and return by how much numbers grew in the elimination.

    Parameters
    ----------
    receptance
        The rail's receptances, complex (n, distances), m/N.
    column
        Which of the distances lies between every two axles, (axles, axles).
    flexibility
        Flexibilities that the receptances of all vehicles are made of, complex (terms, n), m/N.
    first_term
        Where the terms between every two axles begin in `term` and `share`, row by row, and where the last
        ones end, (axles² + 1,).
    term, share
        Which of the flexibilities, and how much of it.
    contact
        1/k_H of every axle, (axles,), m/N.
    unevenness
        Sets of w̃, complex (n, axles, sets), m.
    forces
        Where the forces are written, (n, axles, sets).

    Returns
    -------
    ndarray, shape (n,)
        Product of the largest entries of the two triangular factors over the largest of the matrix. Times the
        precision of the numbers, it is the relative perturbation of the matrix whose solution is exact.
    """
    n = receptance.shape[0]
    axles = column.shape[0]
    width = axles + unevenness.shape[2]
    growth = np.empty(n)
    real = np.empty((axles, width, _LANES))
    imag = np.empty((axles, width, _LANES))
    rail = np.empty((2, receptance.shape[1], _LANES))
    terms = np.empty((2, flexibility.shape[0], _LANES))
    largest = np.empty((3, _LANES))
    for first in range(0, n, _LANES):
        count = min(_LANES, n - first)
        _gather(first, count, receptance, flexibility, unevenness, rail, terms, real, imag)
        _assemble(rail, column, terms, first_term, term, share, contact, real, imag)
        _write_largest(axles, real, imag, largest[0])
        _eliminate(axles, width, real, imag, largest)
        for w in range(count):
            growth[first + w] = np.sqrt(largest[1, w] * largest[2, w] / largest[0, w])
        _substitute(axles, width, real, imag)
        for w in range(count):
            for i in range(axles):
                for j in range(width - axles):
                    forces[first + w, i, j] = complex(-real[i, axles + j, w], -imag[i, axles + j, w])
    return growth


@fused_kernel
def _gather(first, count, receptance, flexibility, unevenness, rail, terms, real, imag):
    """Write receptances, flexibilities and unevenness of some frequencies side by side."""
    axles = real.shape[0]
    for w in range(_LANES):
        row = first + min(w, count - 1)
        for d in range(receptance.shape[1]):
            rail[0, d, w] = receptance[row, d].real
            rail[1, d, w] = receptance[row, d].imag
        for t in range(flexibility.shape[0]):
            terms[0, t, w] = flexibility[t, row].real
            terms[1, t, w] = flexibility[t, row].imag
        for i in range(axles):
            for j in range(unevenness.shape[2]):
                real[i, axles + j, w] = unevenness[row, i, j].real
                imag[i, axles + j, w] = unevenness[row, i, j].imag


@fused_kernel
def _assemble(rail, column, terms, first_term, term, share, contact, real, imag):
    """Write the matrices side by side."""
    axles = column.shape[0]
    for i in range(axles):
        for j in range(axles):
            d = column[i, j]
            stiff = contact[i] if i == j else 0.0
            for w in range(_LANES):
                real[i, j, w] = rail[0, d, w] + stiff
                imag[i, j, w] = rail[1, d, w]
            pair = i * axles + j
            for place in range(first_term[pair], first_term[pair + 1]):
                t = term[place]
                part = share[place]
                for w in range(_LANES):
                    real[i, j, w] += part * terms[0, t, w]
                    imag[i, j, w] += part * terms[1, t, w]


@fused_kernel
def _write_largest(axles, real, imag, largest):
    """Write the largest squared entries of the matrices."""
    for w in range(_LANES):
        largest[w] = 0.0
    for i in range(axles):
        for j in range(axles):
            for w in range(_LANES):
                size = real[i, j, w] * real[i, j, w] + imag[i, j, w] * imag[i, j, w]
                largest[w] = max(largest[w], size)


@fused_kernel
def _eliminate(axles, width, real, imag, largest):
    """Eliminate below the diagonal; write the factors' largest squared entries to rows 1 and 2."""
    pivot = np.empty((2, _LANES))
    factor = np.empty((2, _LANES))
    for w in range(_LANES):
        largest[1, w] = 1.0  # on the diagonal of the lower factor
        largest[2, w] = 0.0
    for k in range(axles):
        for w in range(_LANES):
            inverse = reciprocal(complex(real[k, k, w], imag[k, k, w]))
            pivot[0, w] = inverse.real
            pivot[1, w] = inverse.imag
        for i in range(k + 1, axles):
            for w in range(_LANES):
                entry = complex(real[i, k, w], imag[i, k, w]) * complex(pivot[0, w], pivot[1, w])
                factor[0, w] = entry.real
                factor[1, w] = entry.imag
                largest[1, w] = max(largest[1, w], entry.real * entry.real + entry.imag * entry.imag)
            for j in range(k + 1, width):
                _subtract_row(real, imag, i * width + j, k * width + j, factor)
        for j in range(k, width):
            for w in range(_LANES):
                size = real[k, j, w] * real[k, j, w] + imag[k, j, w] * imag[k, j, w]
                largest[2, w] = max(largest[2, w], size if j < axles else 0.0)
                entry = complex(real[k, j, w], imag[k, j, w]) * complex(pivot[0, w], pivot[1, w])
                real[k, j, w] = entry.real
                imag[k, j, w] = entry.imag


@fused_kernel
def _substitute(axles, width, real, imag):
    """Replace the right-hand sides by the solution, from the last row up."""
    factor = np.empty((2, _LANES))
    for k in range(axles - 1, 0, -1):
        for i in range(k):
            for w in range(_LANES):
                factor[0, w] = real[i, k, w]
                factor[1, w] = imag[i, k, w]
            for j in range(axles, width):
                _subtract_row(real, imag, i * width + j, k * width + j, factor)
