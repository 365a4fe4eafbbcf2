"""Kernels of rational fits in ρ²; see `railvib.soil.barycentric`.

Symbols: r wavenumber, f a function of it, z support points and poles in r², w barycentric weights. Matrices
are laid out as LAPACK wants them, column by column.
"""

import numpy as np

from railvib.numerics.jit import kernel, reduction_kernel
from railvib.numerics.vector_math import reciprocal


@kernel
def cauchy_matrix(r, r_support):
    """Return 1/(r² − r_j²), rows j, columns r."""
    out = np.empty((r_support.shape[0], r.shape[0]))
    for j in range(r_support.shape[0]):
        for i in range(r.shape[0]):
            out[j, i] = 1.0 / ((r[i] - r_support[j]) * (r[i] + r_support[j]))
    return out


@kernel
def loewner_matrix(cauchy, f, f_support, row, column):
    """Return (f − f_j)/(r² − r_j²)·row·column, (functions × samples, supports).

    `f` and `row` are (functions, samples), `f_support` (functions, supports), `column` (supports,).
    """
    functions, samples = f.shape
    out = np.empty((cauchy.shape[0], functions * samples), np.complex128)
    for j in range(cauchy.shape[0]):
        for q in range(functions):
            for i in range(samples):
                value = (f[q, i] - f_support[q, j]) * (cauchy[j, i] * row[q, i] * column[j])
                out[j, q * samples + i] = value
    return out.T


@kernel
def barycentric_errors(cauchy, weight, f_support, f):
    """Return the relative errors of barycentric forms where they should be f (functions, samples).

    Of every sample the largest of all functions, (samples,).
    """
    functions, samples = f.shape
    error = np.zeros(samples)
    above = np.empty(samples, np.complex128)
    below = np.zeros(samples, np.complex128)
    for j in range(cauchy.shape[0]):
        for i in range(samples):
            below[i] += weight[j] * cauchy[j, i]
    for q in range(functions):
        for i in range(samples):
            above[i] = 0.0
        for j in range(cauchy.shape[0]):
            product = weight[j] * f_support[q, j]
            for i in range(samples):
                above[i] += product * cauchy[j, i]
        for i in range(samples):
            size = abs(above[i] * reciprocal(below[i] * f[q, i]) - 1.0)
            if not size <= error[i]:  # also where it is not a number
                error[i] = size
    return error


@reduction_kernel
def polish_zeros(zero, z_support, weight, sweeps):
    """Improve zeros of Σ w_j/(z − z_j) in place, all together (Ehrlich–Aberth); return if they converge."""
    n = zero.shape[0]
    converged = np.zeros(n, np.bool_)
    for _ in range(sweeps):
        remaining = 0
        for i in range(n):
            if converged[i]:
                continue
            value = 0j
            slope = 0j
            lift = 0j
            for j in range(z_support.shape[0]):
                u = reciprocal(zero[i] - z_support[j])
                weighted = weight[j] * u
                value += weighted
                slope -= weighted * u
                lift += u
            if value == 0j:
                converged[i] = True
                continue
            for j in range(i):
                lift -= reciprocal(zero[i] - zero[j])
            for j in range(i + 1, n):
                lift -= reciprocal(zero[i] - zero[j])
            step = reciprocal(slope * reciprocal(value) + lift)
            zero[i] -= step
            if abs(step) < 1e-7 * abs(zero[i]):  # convergence is cubic: nothing is left after this step
                converged[i] = True
            else:
                remaining += 1
        if remaining == 0:
            return True
    return False


@kernel
def partial_fractions(r, pole, row):
    """Return row/(r² − z_j) and row as columns of length one, and the factors that made them so."""
    n = pole.shape[0]
    out = np.empty((n + 1, r.shape[0]), np.complex128)
    scale = np.empty(n + 1)
    for j in range(n + 1):
        squared = 0.0
        for i in range(r.shape[0]):
            if j < n:
                out[j, i] = row[i] * reciprocal(r[i] * r[i] - pole[j])
            else:
                out[j, i] = row[i]
            squared += out[j, i].real ** 2 + out[j, i].imag ** 2
        scale[j] = 1.0 / np.sqrt(squared)
        for i in range(r.shape[0]):
            out[j, i] *= scale[j]
    return out.T, scale


@kernel
def partial_fraction_errors(r, f, pole, residue, constant):
    """Return the relative errors of partial fractions where they should be f, (samples,)."""
    value = np.full(r.shape[0], constant)
    for j in range(pole.shape[0]):
        for i in range(r.shape[0]):
            value[i] += residue[j] * reciprocal(r[i] * r[i] - pole[j])
    return np.abs(value / f - 1.0)
