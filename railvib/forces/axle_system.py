"""The equations of the axles of a train, coupled by vehicles and rail, at many frequencies.

    (Σ_T + Σ_R + I/k_H) P = −w̃        (Eq. 12)

Frequencies are taken some at a time, side by side in vector registers, through an elimination that leaves the
rows in their order. Receptances that dissipate allow that; whether it was allowed is told for each frequency.
"""

import numpy as np

from railvib.numerics.intrinsics import row_subtraction
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import reciprocal
from railvib.parameters.vehicle import AXLES, SHAPES

_LANES = 32
"""Frequencies side by side: the matrices of a train of sixteen axles then stay near the core."""
_subtract_row = row_subtraction(_LANES)


@fused_kernel
def solve(receptance, column, flexibility, kind, contact, unevenness, forces):
    """Write the forces, and return by how much numbers grew in the elimination.

    Parameters
    ----------
    receptance
        The rail's receptances, complex (n, distances), m/N.
    column
        Which of the distances every two axles have, (axles, axles).
    flexibility
        Flexibilities of the chains of every kind of vehicle, complex (kinds, chains, n), m/N, as in
        `railvib.parameters.vehicle.chain_flexibilities`.
    kind
        Kind of every vehicle, ascending in x, (vehicles,).
    contact
        1/k_H of every axle, (axles,), m/N.
    unevenness
        Sets of w̃, complex (n, axles, sets), m.
    forces
        Where the forces are written, (n, axles, sets).

    Returns
    -------
    ndarray, shape (n,)
        Product of the largest entries of the two triangular factors over the largest of the matrix: times the
        precision of the numbers, the relative error of the matrix whose exact solution was found.
    """
    n = receptance.shape[0]
    axles = column.shape[0]
    sets = unevenness.shape[2]
    width = axles + sets
    growth = np.empty(n)
    real = np.empty((axles, width, _LANES))
    imag = np.empty((axles, width, _LANES))
    rail = np.empty((2, receptance.shape[1], _LANES))
    chains = np.empty((2, *flexibility.shape[:2], _LANES))
    pivot = np.empty((2, _LANES))
    factor = np.empty((2, _LANES))
    largest = np.empty((3, _LANES))
    for first in range(0, n, _LANES):
        count = min(_LANES, n - first)
        for w in range(_LANES):
            row = first + min(w, count - 1)
            for d in range(receptance.shape[1]):
                rail[0, d, w] = receptance[row, d].real
                rail[1, d, w] = receptance[row, d].imag
            for own in range(flexibility.shape[0]):
                for chain in range(flexibility.shape[1]):
                    chains[0, own, chain, w] = flexibility[own, chain, row].real
                    chains[1, own, chain, w] = flexibility[own, chain, row].imag
            for i in range(axles):
                for j in range(sets):
                    real[i, axles + j, w] = unevenness[row, i, j].real
                    imag[i, axles + j, w] = unevenness[row, i, j].imag
        _set_up(rail, column, chains, kind, contact, real, imag)
        _largest(axles, real, imag, largest[0])
        for w in range(_LANES):
            largest[1, w] = 1.0  # of the lower factor, whose diagonal is of ones
            largest[2, w] = 0.0
        for k in range(axles):
            for w in range(_LANES):
                inverse = reciprocal(complex(real[k, k, w], imag[k, k, w]))
                pivot[0, w] = inverse.real
                pivot[1, w] = inverse.imag
            for i in range(k + 1, axles):
                for w in range(_LANES):
                    each = complex(real[i, k, w], imag[i, k, w]) * complex(pivot[0, w], pivot[1, w])
                    factor[0, w] = each.real
                    factor[1, w] = each.imag
                    largest[1, w] = max(largest[1, w], each.real * each.real + each.imag * each.imag)
                for j in range(k + 1, width):
                    _subtract_row(real, imag, i * width + j, k * width + j, factor)
            for j in range(k, width):
                for w in range(_LANES):
                    size = real[k, j, w] * real[k, j, w] + imag[k, j, w] * imag[k, j, w]
                    largest[2, w] = max(largest[2, w], size if j < axles else 0.0)
                    each = complex(real[k, j, w], imag[k, j, w]) * complex(pivot[0, w], pivot[1, w])
                    real[k, j, w] = each.real
                    imag[k, j, w] = each.imag
        for w in range(count):
            growth[first + w] = np.sqrt(largest[1, w] * largest[2, w] / largest[0, w])
        for k in range(axles - 1, 0, -1):
            for i in range(k):
                for w in range(_LANES):
                    factor[0, w] = real[i, k, w]
                    factor[1, w] = imag[i, k, w]
                for j in range(axles, width):
                    _subtract_row(real, imag, i * width + j, k * width + j, factor)
        for w in range(count):
            for i in range(axles):
                for j in range(sets):
                    forces[first + w, i, j] = complex(-real[i, axles + j, w], -imag[i, axles + j, w])
    return growth


@fused_kernel
def _set_up(rail, column, chains, kind, contact, real, imag):
    """Write the matrices side by side."""
    axles = column.shape[0]
    for i in range(axles):
        for j in range(axles):
            d = column[i, j]
            stiff = contact[i] if i == j else 0.0
            for w in range(_LANES):
                real[i, j, w] = rail[0, d, w] + stiff
                imag[i, j, w] = rail[1, d, w]
            if i // AXLES == j // AXLES:
                own = kind[i // AXLES]
                for chain in range(chains.shape[2]):
                    share = SHAPES[chain, i % AXLES, j % AXLES]
                    for w in range(_LANES):
                        real[i, j, w] += share * chains[0, own, chain, w]
                        imag[i, j, w] += share * chains[1, own, chain, w]


@fused_kernel
def _largest(axles, real, imag, largest):
    """Write the largest squared entries of the matrices."""
    for w in range(_LANES):
        largest[w] = 0.0
    for i in range(axles):
        for j in range(axles):
            for w in range(_LANES):
                size = real[i, j, w] * real[i, j, w] + imag[i, j, w] * imag[i, j, w]
                largest[w] = max(largest[w], size)
