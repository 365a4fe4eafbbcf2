"""Rational fit of the ground's flexibility in ρ², once per soil and frequency.

    Q33(ρ) ≈ d + Σ_j a_j/(ρ² − z_j)

The fit is a greedy barycentric one (AAA), weighted by 1/|Q33| so that large wavenumbers, where Q33 is small
but still counts in every integral, are fitted as well as the peaks. Samples lie at ρ = k0 sinh(x), at least a
few between neighbouring support points, and the fit is judged at points it has not seen: that error is its
certificate. See docs/theory/ground.md.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from railvib.numerics import threads
from railvib.numerics.jit import kernel, reduction_kernel
from railvib.numerics.vector_math import reciprocal
from railvib.parameters.ground import Ground
from railvib.soil.flexibility import surface_flexibilities

MOST_TERMS = 220
_SAMPLES_PER_GAP = 4
_ROUNDS = 4
_MOST_SWEEPS = 20


@dataclass(frozen=True)
class Start:
    """Support points and poles of a fit, as they hardly change from one frequency to the next."""

    support: np.ndarray
    """Support points x = asinh(ρ/k0), ascending."""
    pole: np.ndarray
    """Zeros of the barycentric denominator, over k0²; one less than support points."""


@dataclass(frozen=True)
class RationalFit:
    """Poles, residues and constant of Q33 as a function of ρ², at one frequency."""

    pole: np.ndarray
    """z_j, complex (p,), (rad/m)²."""
    residue: np.ndarray
    """a_j, complex (p,), (rad/m)²·m/Pa."""
    constant: complex
    """d, m/Pa."""
    error: float
    """Largest relative error at wavenumbers that the fit has not seen."""
    start: "Start"
    """What a neighbouring frequency's fit starts from."""

    def flexibility(self, wavenumber: np.ndarray) -> np.ndarray:
        """Return the fitted Q33 at real wavenumbers (n,), m/Pa."""
        r = np.asarray(wavenumber, float)
        return np.asarray(self.constant + (self.residue / (r[:, None] ** 2 - self.pole)).sum(axis=1))

    def scaled(self, ratio: float) -> "RationalFit":
        """Return a half-space's fit at `ratio` times the frequency: its Q33 is a function of ρ/ω, over ω."""
        return RationalFit(
            self.pole * ratio**2, self.residue * ratio, self.constant / ratio, self.error, self.start
        )


def fit_range(ground: Ground, frequency: float) -> tuple[float, float]:
    """Return (k0, G): the scale of the samples ρ = k0 sinh(x), and the largest wavenumber fitted, rad/m."""
    omega = 2.0 * np.pi * frequency
    speeds = list(ground.wave_speeds())
    return 0.3 * omega / max(speeds), max(300.0, 20.0 * omega / min(speeds))


def fit_flexibility(
    ground: Ground,
    frequency: float,
    tolerance: float = 1e-9,
    start: Start | None = None,
    largest: float | None = None,
) -> RationalFit:
    """Fit Q33 of a ground at one positive frequency.

    Parameters
    ----------
    ground
        The layered ground.
    frequency
        Frequency, Hz, positive.
    tolerance
        Relative error aimed at, everywhere on 0 ≤ ρ ≤ G of `fit_range`.
    start
        That of a neighbouring frequency's fit.
    largest
        Fit up to this wavenumber, rad/m, where it is more than G.

    Returns
    -------
    RationalFit
        Its `error` tells whether it reached the tolerance; the caller decides what to do where it did not.
    """
    omega = 2.0 * np.pi * frequency
    stack = ground.stack()
    rigid = ground.base == "rigid"
    k0, usual = fit_range(ground, frequency)
    largest = max(usual, largest or 0.0)
    z0 = 30.0 * (omega / ground.slowest_speed) ** 2
    x_largest = float(np.arcsinh(largest / k0))

    def flexibility(r: np.ndarray) -> np.ndarray:
        return np.asarray(surface_flexibilities(r, omega, stack, rigid))

    guess = None
    if start is None:
        support = np.linspace(0.0, x_largest, 12)
    else:
        support = np.append(start.support[start.support < 0.999 * x_largest], x_largest)
        guess = start.pole * k0**2
    with threads.single():
        return _fitted(ground, flexibility, support, guess, k0, z0, largest, tolerance)


def _fitted(
    ground: Ground,
    flexibility: Callable[[np.ndarray], np.ndarray],
    support: np.ndarray,
    guess: np.ndarray | None,
    k0: float,
    z0: float,
    largest: float,
    tolerance: float,
) -> RationalFit:
    """Return the fit that grows from some support points x = asinh(ρ/k0), its poles from a guess."""
    samples = _SAMPLES_PER_GAP
    for _ in range(_ROUNDS):
        support, f_support, weight, x, f = _greedy_supports(flexibility, support, k0, z0, tolerance, samples)
        r_support = k0 * np.sinh(support)
        x_seen = np.concatenate([support, x])
        order = np.argsort(x_seen)
        x_seen, f_seen = x_seen[order], np.concatenate([f_support, f])[order]
        r_unseen = k0 * np.sinh(0.5 * (x_seen[1:] + x_seen[:-1]))
        f_unseen = flexibility(r_unseen)
        error = _barycentric_errors(_cauchy(r_unseen, r_support), weight, f_support, f_unseen)
        if error.max() <= 2.0 * tolerance or support.size >= MOST_TERMS:
            break
        samples = 2 * samples + 1
    zero = poles(r_support**2, weight, z0, guess)
    pole = clean(zero, largest, min(layer.loss_factor for layer in ground.layers))
    residue, constant = _residues(k0 * np.sinh(x_seen), f_seen, pole)
    checked = _partial_fraction_errors(r_unseen, f_unseen, pole, residue, constant).max()
    return RationalFit(pole, residue, constant, float(checked), Start(support, zero / k0**2))


Supports = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Support points x and values there, barycentric weights, the samples' x and values."""


def _greedy_supports(
    flexibility: Callable[[np.ndarray], np.ndarray],
    support: np.ndarray,
    k0: float,
    z0: float,
    tolerance: float,
    samples: int,
) -> Supports:
    """Add support points at the error's maxima until all samples between them fit."""
    inside = (np.arange(samples) + 0.5) / samples
    while True:
        x = (support[:-1, None] + np.diff(support)[:, None] * inside).ravel()
        r = k0 * np.sinh(np.concatenate([support, x]))
        values = flexibility(r)
        r_support, r = r[: support.size], r[support.size :]
        f_support, f = values[: support.size], values[support.size :]
        cauchy = _cauchy(r, r_support)
        loewner = _loewner(cauchy, f, f_support, (r**2 + z0) / np.abs(f), r_support**2 + z0)
        weight = (r_support**2 + z0) * _smallest_singular_vector(loewner)
        error = _barycentric_errors(cauchy, weight, f_support, f).reshape(-1, samples)
        worst = error.max(axis=1)
        if worst.max() <= tolerance or support.size >= MOST_TERMS:
            return support, f_support, weight, x, f
        # New supports in the gaps with the largest errors, at most a tenth of those there are.
        most = max(1, support.size // 10)
        gaps = np.argsort(worst)[::-1][:most]
        gaps = gaps[worst[gaps] > max(0.5 * tolerance, 1e-3 * worst.max())]
        new = x.reshape(-1, samples)[gaps, error[gaps].argmax(axis=1)]
        support = np.sort(np.concatenate([support, new]))


@kernel
def _cauchy(r, r_support):
    """Return 1/(r² − r_j²), rows j, columns r; the matrices here are laid out as LAPACK wants them."""
    out = np.empty((r_support.shape[0], r.shape[0]))
    for j in range(r_support.shape[0]):
        for i in range(r.shape[0]):
            out[j, i] = 1.0 / ((r[i] - r_support[j]) * (r[i] + r_support[j]))
    return out


@kernel
def _loewner(cauchy, f, f_support, row, column):
    """Return the scaled Loewner matrix, samples by support points."""
    out = np.empty(cauchy.shape, np.complex128)
    for j in range(cauchy.shape[0]):
        for i in range(cauchy.shape[1]):
            out[j, i] = (f[i] - f_support[j]) * (cauchy[j, i] * row[i] * column[j])
    return out.T


def _smallest_singular_vector(matrix: np.ndarray) -> np.ndarray:
    """Return the right singular vector of the smallest singular value: QR, then inverse iteration on RᴴR."""
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


@kernel
def _barycentric_errors(cauchy, weight, f_support, f):
    """Return the relative errors of the barycentric form where it should be f."""
    error = np.empty(f.shape[0])
    above = np.zeros(f.shape[0], np.complex128)
    below = np.zeros(f.shape[0], np.complex128)
    for j in range(cauchy.shape[0]):
        product = weight[j] * f_support[j]
        for i in range(f.shape[0]):
            above[i] += product * cauchy[j, i]
            below[i] += weight[j] * cauchy[j, i]
    for i in range(f.shape[0]):
        error[i] = abs(above[i] * reciprocal(below[i] * f[i]) - 1.0)
    return error


def poles(
    z_support: np.ndarray, weight: np.ndarray, z0: float, guess: np.ndarray | None = None
) -> np.ndarray:
    """Return the zeros of Σ w_j/(z − z_j), from a neighbour's as a guess where there are as many of them."""
    n = z_support.size
    if guess is not None and guess.size == n - 1:
        pole = guess.copy()
        if _polish(pole, z_support, weight, _MOST_SWEEPS):
            return pole
    # Eigenvalues in t = (z − z0)/(z + z0), polished in z.
    t = (z_support - z0) / (z_support + z0)
    w = weight * (1.0 - t)
    companion = np.diag(t).astype(complex) - np.outer(np.ones(n), w * t) / w.sum()
    root = np.linalg.eigvals(companion)
    root = np.delete(root, np.argmin(np.abs(root)))  # the one zero that the rank-one update brings in
    pole = z0 * (1.0 + root) / (1.0 - root)
    _polish(pole, z_support, weight, _MOST_SWEEPS)
    return pole


@reduction_kernel
def _polish(pole, z_support, weight, sweeps):
    """Improve zeros of Σ w_j/(z − z_j) in place, all together (Ehrlich–Aberth); tell whether they stand."""
    n = pole.shape[0]
    done = np.zeros(n, np.bool_)
    for _ in range(sweeps):
        left = 0
        for i in range(n):
            if done[i]:
                continue
            value = 0j
            slope = 0j
            lift = 0j
            for j in range(z_support.shape[0]):
                u = reciprocal(pole[i] - z_support[j])
                weighted = weight[j] * u
                value += weighted
                slope -= weighted * u
                lift += u
            if value == 0j:
                done[i] = True
                continue
            for j in range(i):
                lift -= reciprocal(pole[i] - pole[j])
            for j in range(i + 1, n):
                lift -= reciprocal(pole[i] - pole[j])
            step = reciprocal(slope * reciprocal(value) + lift)
            pole[i] -= step
            if abs(step) < 1e-7 * abs(pole[i]):  # convergence is cubic: nothing is left after this step
                done[i] = True
            else:
                left += 1
        if left == 0:
            return True
    return False


def clean(pole: np.ndarray, largest: float, loss_factor: float) -> np.ndarray:
    """Move stray poles near the end of the range off the real axis; drop those too close to it."""
    k = np.sqrt(pole)
    stray = (np.abs(k.real) > 0.8 * largest) & (np.abs(k.imag) < np.abs(k.real))
    pole = np.where(stray, -np.abs(pole), pole)
    spurious = ~stray & (np.abs(k.imag) < 0.02 * loss_factor * np.abs(k.real))
    return np.asarray(pole[~spurious])


def _residues(r: np.ndarray, f: np.ndarray, pole: np.ndarray) -> tuple[np.ndarray, complex]:
    """Return residues and constant by column-scaled least squares with relative weights."""
    matrix, scale = _partial_fractions(r, pole, 1.0 / np.abs(f))
    right = f / np.abs(f)
    _factored, solution, info = lapack.zgels(matrix, right)
    found = solution[: scale.size] if info == 0 else np.linalg.lstsq(matrix, right, rcond=None)[0]
    found = found * scale
    return found[:-1], complex(found[-1])


@kernel
def _partial_fractions(r, pole, row):
    """Return row/(r² − z_j) and row as columns of length one, and what they were multiplied with for that."""
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
def _partial_fraction_errors(r, f, pole, residue, constant):
    """Return the relative errors of the partial fractions where they should be f."""
    value = np.full(r.shape[0], constant)
    for j in range(pole.shape[0]):
        for i in range(r.shape[0]):
            value[i] += residue[j] * reciprocal(r[i] * r[i] - pole[j])
    return np.abs(value / f - 1.0)
