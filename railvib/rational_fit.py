"""Rational fit of the ground's flexibility in ρ², once per soil and frequency.

    Q33(ρ) ≈ d + Σ_j a_j/(ρ² − z_j)

The fit is a greedy barycentric one (AAA), weighted by 1/|Q33| so that large wavenumbers, where Q33 is small
but still counts in every integral, are fitted as well as the peaks. Samples lie at ρ = k0 sinh(x), at least a
few between neighbouring support points, and the fit is judged at points it has not seen: that error is its
certificate. See docs/theory/ground.md.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np
from scipy.linalg import lapack
from threadpoolctl import ThreadpoolController

from railvib.flexibility import surface_flexibilities
from railvib.ground import Ground

MOST_TERMS = 220
_SAMPLES_PER_GAP = 4
_LINEAR_ALGEBRA = ThreadpoolController()
"""The matrices are so small that handing them to several threads costs ten times what it saves."""
_ROUNDS = 4


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
    support: np.ndarray
    """Support points as x = asinh(ρ/k0), to start a neighbouring frequency's fit from."""

    def flexibility(self, wavenumber: np.ndarray) -> np.ndarray:
        """Return the fitted Q33 at real wavenumbers (n,), m/Pa."""
        r = np.asarray(wavenumber, float)
        return np.asarray(self.constant + (self.residue / (r[:, None] ** 2 - self.pole)).sum(axis=1))

    def scaled(self, ratio: float) -> "RationalFit":
        """Return a half-space's fit at `ratio` times the frequency: its Q33 is a function of ρ/ω, over ω."""
        return RationalFit(
            self.pole * ratio**2, self.residue * ratio, self.constant / ratio, self.error, self.support
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
    start: np.ndarray | None = None,
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
        Support points of a neighbouring frequency's fit.
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

    if start is None:
        support = np.linspace(0.0, x_largest, 12)
    else:
        support = np.append(start[start < 0.999 * x_largest], x_largest)
    with _LINEAR_ALGEBRA.limit(limits=1, user_api="blas"):
        return _fitted(ground, flexibility, support, k0, z0, largest, tolerance)


def _fitted(
    ground: Ground,
    flexibility: Callable[[np.ndarray], np.ndarray],
    support: np.ndarray,
    k0: float,
    z0: float,
    largest: float,
    tolerance: float,
) -> RationalFit:
    """Return the fit that grows from some support points x = asinh(ρ/k0)."""
    samples = _SAMPLES_PER_GAP
    for _ in range(_ROUNDS):
        support, weight, x_seen = _greedy_supports(flexibility, support, k0, z0, tolerance, samples)
        r_support = k0 * np.sinh(support)
        f_support = flexibility(r_support)
        x_unseen = 0.5 * (x_seen[1:] + x_seen[:-1])
        r_unseen = k0 * np.sinh(x_unseen)
        f_unseen = flexibility(r_unseen)
        error = np.abs(_barycentric(r_unseen, r_support, weight, f_support) / f_unseen - 1.0)
        if error.max() <= 2.0 * tolerance or support.size >= MOST_TERMS:
            break
        samples = 2 * samples + 1
    pole = poles(r_support**2, weight, z0)
    pole = clean(pole, largest, min(layer.loss_factor for layer in ground.layers))
    r_all = k0 * np.sinh(np.concatenate([x_seen, x_unseen]))
    f_all = flexibility(r_all)
    residue, constant = _residues(r_all, f_all, pole)
    x_check = 0.5 * (x_seen[1:] + x_unseen)
    r_check = k0 * np.sinh(x_check)
    fit = RationalFit(pole, residue, constant, np.nan, support)
    checked = np.abs(fit.flexibility(r_check) / flexibility(r_check) - 1.0).max()
    return RationalFit(pole, residue, constant, float(checked), support)


def _greedy_supports(flexibility, support, k0, z0, tolerance, samples):
    """Add support points at the error's maxima until all samples fit; return supports, weights, sampled x."""
    inside = (np.arange(samples) + 0.5) / samples
    while True:
        x = (support[:-1, None] + np.diff(support)[:, None] * inside).ravel()
        r = k0 * np.sinh(x)
        f = flexibility(r)
        r_support = k0 * np.sinh(support)
        f_support = flexibility(r_support)
        column = r_support**2 + z0
        cauchy = 1.0 / ((r[:, None] - r_support) * (r[:, None] + r_support))
        row = (r**2 + z0) / np.abs(f)
        loewner = (f[:, None] - f_support) * cauchy * row[:, None] * column
        weight = column * _smallest_singular_vector(loewner)
        fitted = (cauchy @ (weight * f_support)) / (cauchy @ weight)
        error = np.abs(fitted / f - 1.0).reshape(-1, samples)
        worst = error.max(axis=1)
        if worst.max() <= tolerance or support.size >= MOST_TERMS:
            return support, weight, np.sort(np.concatenate([support, x]))
        # New supports in the gaps with the largest errors, at most a tenth of those there are.
        most = max(1, support.size // 10)
        gaps = np.argsort(worst)[::-1][:most]
        gaps = gaps[worst[gaps] > max(0.5 * tolerance, 1e-3 * worst.max())]
        new = x.reshape(-1, samples)[gaps, error[gaps].argmax(axis=1)]
        support = np.sort(np.concatenate([support, new]))


def _smallest_singular_vector(matrix: np.ndarray) -> np.ndarray:
    """Return the right singular vector of the smallest singular value: QR, then inverse iteration on RᴴR."""
    r: np.ndarray = np.linalg.qr(matrix, mode="r")  # type: ignore[assignment]
    diagonal = np.abs(r.diagonal())
    tiny = 1e-19 * diagonal.max()
    flat = np.flatnonzero(diagonal < tiny)
    r[flat, flat] = tiny
    x = np.full(r.shape[0], 1.0 + 0j)
    for _ in range(4):
        y, _info = lapack.ztrtrs(r, x, trans=2)
        y /= np.linalg.norm(y)
        x, _info = lapack.ztrtrs(r, y)
        x /= np.linalg.norm(x)
    return np.asarray(x)


def _barycentric(
    r: np.ndarray, r_support: np.ndarray, weight: np.ndarray, f_support: np.ndarray
) -> np.ndarray:
    cauchy = 1.0 / ((r[:, None] - r_support) * (r[:, None] + r_support))
    return np.asarray((cauchy @ (weight * f_support)) / (cauchy @ weight))


def poles(z_support: np.ndarray, weight: np.ndarray, z0: float) -> np.ndarray:
    """Return the zeros of Σ w_j/(z − z_j): eigenvalues in t = (z − z0)/(z + z0) as start, polished in z."""
    t = (z_support - z0) / (z_support + z0)
    w = weight * (1.0 - t)
    n = t.size
    companion = np.diag(t).astype(complex) - np.outer(np.ones(n), w * t) / w.sum()
    root = np.linalg.eigvals(companion)
    root = np.delete(root, np.argmin(np.abs(root)))  # the one zero that the rank-one update brings in
    pole = z0 * (1.0 + root) / (1.0 - root)
    _polish(pole, z_support, weight)
    return pole


@numba.njit(cache=True, error_model="numpy")
def _polish(pole, z_support, weight):
    """Improve the zeros of Σ w_j/(z − z_j) in place, all together (Ehrlich–Aberth)."""
    n = pole.shape[0]
    done = np.zeros(n, np.bool_)
    for _ in range(12):
        left = 0
        for i in range(n):
            if done[i]:
                continue
            value = 0j
            slope = 0j
            lift = 0j
            for j in range(z_support.shape[0]):
                u = 1.0 / (pole[i] - z_support[j])
                value += weight[j] * u
                slope -= weight[j] * u * u
                lift += u
            if abs(value) == 0.0:
                done[i] = True
                continue
            for j in range(n):
                if j != i:
                    lift -= 1.0 / (pole[i] - pole[j])
            step = 1.0 / (slope / value + lift)
            pole[i] -= step
            if abs(step) < 1e-14 * abs(pole[i]):
                done[i] = True
            else:
                left += 1
        if left == 0:
            break


def clean(pole: np.ndarray, largest: float, loss_factor: float) -> np.ndarray:
    """Move stray poles near the end of the range off the real axis; drop those too close to it."""
    k = np.sqrt(pole)
    stray = (np.abs(k.real) > 0.8 * largest) & (np.abs(k.imag) < np.abs(k.real))
    pole = np.where(stray, -np.abs(pole), pole)
    spurious = ~stray & (np.abs(k.imag) < 0.02 * loss_factor * np.abs(k.real))
    return np.asarray(pole[~spurious])


def _residues(r: np.ndarray, f: np.ndarray, pole: np.ndarray) -> tuple[np.ndarray, complex]:
    """Return residues and constant by column-scaled least squares with relative weights."""
    weight = 1.0 / np.abs(f)
    matrix = np.empty((r.size, pole.size + 1), complex)
    matrix[:, :-1] = 1.0 / (r[:, None] ** 2 - pole)
    matrix[:, -1] = 1.0
    matrix *= weight[:, None]
    scale = 1.0 / np.linalg.norm(matrix, axis=0)
    q, upper = np.linalg.qr(matrix * scale)
    solution, info = lapack.ztrtrs(upper, q.conj().T @ (f * weight))
    if info:
        solution = np.linalg.lstsq(matrix * scale, f * weight, rcond=None)[0]
    solution = solution * scale
    return solution[:-1], complex(solution[-1])
