"""Rational fits in ρ² of several functions on common poles: the greedy barycentric algorithm (AAA).

All functions are fitted with the same weights, so they share their poles (Nakatsukasa, Sète and Trefethen
2018; of several functions Lietaert, Meerbergen, Pérez and Vandereycken 2022). Samples lie at ρ = k0 sinh(x),
a few between neighbouring support points. Each function counts over its own size, so that large wavenumbers,
where flexibilities are small but still count in every integral, are fitted as well as the peaks.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from railvib.parameters.ground import Ground
from railvib.soil._kernels.barycentric import (
    barycentric_errors,
    cauchy_matrix,
    loewner_matrix,
    partial_fractions,
    polish_zeros,
)

Functions = Callable[[np.ndarray], np.ndarray]
"""Values (functions, n) at wavenumbers (n,)."""
_FIRST_SUPPORTS = 12
_SAMPLES_PER_GAP = 4
_ROUNDS = 4
_MOST_SWEEPS = 20


@dataclass(frozen=True)
class Range:
    """The wavenumbers at which a ground is fitted at one frequency."""

    scale: float
    """k0: samples lie at ρ = k0 sinh(x), rad/m."""
    largest: float
    """Largest wavenumber, rad/m."""
    square: float
    """z0: ρ² of this size or less count alike, (rad/m)²."""
    loss_factor: float
    """Of the layer that is damped least: no pole of the ground lies nearer to the real axis."""

    def wavenumber(self, x: np.ndarray) -> np.ndarray:
        """Return ρ = k0 sinh(x), rad/m."""
        return np.asarray(self.scale * np.sinh(x))


def fit_range(ground: Ground, frequency: float, largest: float = 0.0) -> Range:
    """Return the range of wavenumbers of a fit at a frequency in Hz, up to `largest` in rad/m or further."""
    omega = 2.0 * np.pi * frequency
    speeds = list(ground.wave_speeds())
    return Range(
        scale=0.3 * omega / max(speeds),
        largest=max(300.0, 20.0 * omega / min(speeds), largest),
        square=30.0 * (omega / ground.slowest_speed) ** 2,
        loss_factor=min(layer.loss_factor for layer in ground.layers),
    )


@dataclass(frozen=True)
class Start:
    """Support points and poles of a fit, as they hardly change from one frequency to the next."""

    support: np.ndarray
    """Support points x = asinh(ρ/k0), ascending."""
    pole: np.ndarray
    """Zeros of the barycentric denominator, over k0²; one less than support points."""


@dataclass(frozen=True)
class Samples:
    """Values of functions at wavenumbers."""

    x: np.ndarray
    """asinh(ρ/k0), ascending, (n,)."""
    value: np.ndarray
    """(functions, n)."""


@dataclass(frozen=True)
class CommonPoles:
    """Poles on which functions can be fitted together."""

    pole: np.ndarray
    """z_j, complex (p,), (rad/m)²."""
    start: Start
    """What the fit at a neighbouring frequency starts from."""
    seen: Samples
    """Samples, the support points included, that gave the poles."""
    unseen: Samples
    """Samples half-way between these, at which the barycentric form was checked."""


def common_poles(
    functions: Functions, within: Range, tolerance: float, most_terms: int, start: Start | None = None
) -> CommonPoles:
    """Return poles on which functions of ρ² can be fitted.

    Parameters
    ----------
    functions
        Returns the functions' values, complex (functions, n), at wavenumbers (n,) in rad/m.
    within
        The wavenumbers.
    tolerance
        Relative error aimed at.
    most_terms
        Support points at which the algorithm ends, whatever the error.
    start
        Of a neighbouring frequency's fit.
    """
    largest = float(np.arcsinh(within.largest / within.scale))
    guess = None
    if start is None:
        support = np.linspace(0.0, largest, _FIRST_SUPPORTS)
    else:
        support = np.append(start.support[start.support < 0.999 * largest], largest)
        guess = start.pole * within.scale**2
    samples = _SAMPLES_PER_GAP
    for _ in range(_ROUNDS):
        support, f_support, weight, x, f = _add_supports(
            functions, support, within, tolerance, most_terms, samples
        )
        r_support = within.wavenumber(support)
        x_seen = np.concatenate([support, x])
        order = np.argsort(x_seen)
        seen = Samples(x_seen[order], np.concatenate([f_support, f], axis=1).take(order, axis=1))
        between = 0.5 * (seen.x[1:] + seen.x[:-1])
        r = within.wavenumber(between)
        unseen = Samples(between, functions(r))
        error = barycentric_errors(cauchy_matrix(r, r_support), weight, f_support, unseen.value)
        if error.max() <= 2.0 * tolerance or support.size >= most_terms:
            break
        samples = 2 * samples + 1
    zero = _zeros(r_support**2, weight, within.square, guess)
    return CommonPoles(_physical(zero, within), Start(support, zero / within.scale**2), seen, unseen)


def _add_supports(
    functions: Functions,
    support: np.ndarray,
    within: Range,
    tolerance: float,
    most_terms: int,
    samples: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Add support points at the errors' maxima until all samples between them fit.

    Returns the support points x, the functions there, their weights, the samples' x and the functions there.
    """
    inside = (np.arange(samples) + 0.5) / samples
    while True:
        x = (support[:-1, None] + np.diff(support)[:, None] * inside).ravel()
        r = within.wavenumber(np.concatenate([support, x]))
        value = functions(r)
        r_support, r = r[: support.size], r[support.size :]
        f_support, f = (np.ascontiguousarray(part) for part in np.split(value, [support.size], axis=1))
        cauchy = cauchy_matrix(r, r_support)
        column = r_support**2 + within.square
        row = (r**2 + within.square) / np.abs(f)
        weight = column * _smallest_singular_vector(loewner_matrix(cauchy, f, f_support, row, column))
        error = barycentric_errors(cauchy, weight, f_support, f).reshape(-1, samples)
        worst = error.max(axis=1)
        if worst.max() <= tolerance or support.size >= most_terms:
            return support, f_support, weight, x, f
        # New supports in the gaps with the largest errors, at most a tenth of those there are.
        gaps = np.argsort(worst)[::-1][: max(1, support.size // 10)]
        gaps = gaps[worst[gaps] > max(0.5 * tolerance, 1e-3 * worst.max())]
        new = x.reshape(-1, samples)[gaps, error[gaps].argmax(axis=1)]
        support = np.sort(np.concatenate([support, new]))


def _smallest_singular_vector(matrix: np.ndarray) -> np.ndarray:
    """Return the right singular vector of the smallest singular value: QR, then inverse iteration on RᴴR.

    Of several singular values at the level of rounding it is a mixture, in which no entry vanishes. A single
    vector of an SVD may have entries that are zero; poles that fall on such supports spoil the fit.
    """
    n = matrix.shape[1]
    factored, _tau, _work, _info = lapack.zgeqrf(matrix, overwrite_a=1)
    r = np.asfortranarray(factored[:n])
    diagonal = np.abs(r.diagonal())
    tiny = 1e-19 * diagonal.max()
    flat = np.flatnonzero(diagonal < tiny)
    r[flat, flat] = tiny
    x = np.full(n, 1.0 + 0j)
    for _ in range(4):
        y, _info = lapack.ztrtrs(r, x, trans=2)
        y /= np.linalg.norm(y)
        x, _info = lapack.ztrtrs(r, y)
        x /= np.linalg.norm(x)
    return np.asarray(x)


def _zeros(z_support: np.ndarray, weight: np.ndarray, z0: float, guess: np.ndarray | None) -> np.ndarray:
    """Return the zeros of Σ w_j/(z − z_j), from a guess where there are as many of them."""
    n = z_support.size
    if guess is not None and guess.size == n - 1:
        zero = guess.copy()
        if polish_zeros(zero, z_support, weight, _MOST_SWEEPS):
            return zero
    # Eigenvalues in t = (z − z0)/(z + z0), polished in z.
    t = (z_support - z0) / (z_support + z0)
    w = weight * (1.0 - t)
    companion = np.diag(t).astype(complex) - np.outer(np.ones(n), w * t) / w.sum()
    root = np.linalg.eigvals(companion)
    root = np.delete(root, np.argmin(np.abs(root)))  # the one zero that the rank-one update brings in
    zero = z0 * (1.0 + root) / (1.0 - root)
    polish_zeros(zero, z_support, weight, _MOST_SWEEPS)
    return zero


def _physical(zero: np.ndarray, within: Range) -> np.ndarray:
    """Move stray poles near the end of the range off the real axis; drop those too close to it."""
    k = np.sqrt(zero)
    stray = (np.abs(k.real) > 0.8 * within.largest) & (np.abs(k.imag) < np.abs(k.real))
    pole = np.where(stray, -np.abs(zero), zero)
    spurious = ~stray & (np.abs(k.imag) < 0.02 * within.loss_factor * np.abs(k.real))
    return np.asarray(pole[~spurious])


def residues(r: np.ndarray, f: np.ndarray, size: np.ndarray, pole: np.ndarray) -> tuple[np.ndarray, complex]:
    """Return residues a_j and the constant d of f ≈ d + Σ a_j/(r² − z_j) at samples r, errors over `size`."""
    matrix, scale = partial_fractions(r, pole, 1.0 / size)
    solution = _least_squares(matrix, scale, f / size)
    return solution[:-1], complex(solution[-1])


def residues_through_zero(r: np.ndarray, f: np.ndarray, size: np.ndarray, pole: np.ndarray) -> np.ndarray:
    """Return residues a_j of f ≈ r² Σ a_j/(r² − z_j) at samples r, errors over `size`."""
    matrix, scale = partial_fractions(r, pole, r**2 / size)
    return _least_squares(matrix[:, :-1], scale[:-1], f / size)


def _least_squares(matrix: np.ndarray, scale: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the least-squares solution times the columns' scale."""
    _factored, solution, info = lapack.zgels(matrix, right)
    solution = solution[: scale.size] if info == 0 else np.linalg.lstsq(matrix, right, rcond=None)[0]
    return np.asarray(solution * scale)
