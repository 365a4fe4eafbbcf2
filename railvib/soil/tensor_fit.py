"""Rational fit of the ground's flexibility tensor in ρ², all its parts on common poles.

    q_zz, q_rr, q_tt ≈ d + Σ_j a_j/(ρ² − z_j)        q_d, q_c ≈ Σ_j a_j/(ρ² − z_j)

of `railvib.soil.flexibility_tensor`. Common poles, because then every integral over γ needs the same
exponentials. They come from a set-valued greedy barycentric fit (AAA; Lietaert, Meerbergen, Pérez and
Vandereycken 2022) of q_zz, q_rr and q_tt, each weighted by 1/|q|; the residues from least squares. As in
`railvib.soil.rational_fit` the fit is judged at wavenumbers that it has not seen. The range reaches further:
elements at the edges of the track are small, and feel large wavenumbers.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from railvib.numerics import threads
from railvib.parameters.ground import Ground
from railvib.soil.flexibility_tensor import RR, RZ, TT, ZZ, surface_components
from railvib.soil.rational_fit import clean, fit_range, poles

_MOST_TERMS = 120
_SAMPLES_PER_GAP = 4
_NEGLIGIBLE = 1e-10


@dataclass(frozen=True)
class TensorFit:
    """Poles, residues and constants of the flexibility tensor as functions of ρ², at one frequency."""

    pole: np.ndarray
    """z_j, complex (p,), (rad/m)²."""
    residue: np.ndarray
    """a_j of q_zz, q_rr, q_tt, q_d, q_c, complex (5, p)."""
    constant: np.ndarray
    """d of q_zz, q_rr, q_tt, complex (3,), m/Pa."""
    error: float
    """Largest error at wavenumbers that the fit has not seen, relative to |q_zz| or |q_tt|."""
    support: np.ndarray
    """Support points as x = asinh(ρ/k0), to start a neighbouring frequency's fit from."""

    def parts(self, wavenumber: np.ndarray) -> np.ndarray:
        """Return the fitted q_zz, q_rr, q_tt, q_d, q_c at real wavenumbers (n,), complex (5, n)."""
        terms = 1.0 / (np.asarray(wavenumber, float)[:, None] ** 2 - self.pole)
        value = self.residue @ terms.T
        value[:3] += self.constant[:, None]
        return np.asarray(value)

    def scaled(self, ratio: float) -> "TensorFit":
        """Return a half-space's fit at `ratio` ≥ 1 times the frequency: there ω q depends on ρ/ω only."""
        powers = np.array([1.0, 1.0, 1.0, -1.0, 0.0])[:, None]
        return TensorFit(
            self.pole * ratio**2,
            self.residue * ratio**powers,
            self.constant / ratio,
            self.error,
            self.support,
        )


def fit_tensor(
    ground: Ground,
    frequency: float,
    largest: float,
    tolerance: float = 1e-8,
    start: np.ndarray | None = None,
) -> TensorFit:
    """Fit the flexibility tensor of a ground at one positive frequency.

    Parameters
    ----------
    ground
        The layered ground.
    frequency
        Frequency, Hz, positive.
    largest
        Fit up to this wavenumber, rad/m, or further where the ground's waves ask for it.
    tolerance
        Relative error aimed at.
    start
        Support points of a neighbouring frequency's fit.

    Returns
    -------
    TensorFit
        Its `error` tells whether it reached the tolerance; the caller decides what to do where it did not.
    """
    omega = 2.0 * np.pi * frequency
    stack = ground.stack()
    rigid = ground.base == "rigid"
    k0, usual = fit_range(ground, frequency)
    largest = max(usual, largest)
    x_largest = float(np.arcsinh(largest / k0))
    surface_wave = (omega / ground.slowest_speed) ** 2

    def components(x: np.ndarray) -> np.ndarray:
        return np.asarray(surface_components(k0 * np.sinh(x), omega, stack, rigid))

    if start is None:
        support = np.linspace(0.0, x_largest, 12)
    else:
        support = np.append(start[start < 0.999 * x_largest], x_largest)
    with threads.single():
        support, weight, seen = _supports(components, support, k0, 30.0 * surface_wave, tolerance)
        # A support without weight takes part in no pole, and would let one fall on it.
        carries = np.abs(weight) > _NEGLIGIBLE * np.abs(weight).max()
        pole = poles(
            (k0 * np.sinh(support[carries])) ** 2, weight[carries], largest * float(np.sqrt(surface_wave))
        )
        pole = clean(pole, largest, min(layer.loss_factor for layer in ground.layers))
        fitted = np.sort(np.concatenate([seen, 0.5 * (seen[1:] + seen[:-1])]))[1:]
        residue, constant = _residues(k0 * np.sinh(fitted), components(fitted), pole)
        # Three places between the samples: an error as narrow as a resonance shows at one of them.
        unseen = (fitted[:-1, None] + np.diff(fitted)[:, None] * [0.25, 0.5, 0.75]).ravel()
        fit = TensorFit(pole, residue, constant, np.nan, support)
        error = _error(fit, k0 * np.sinh(unseen), components(unseen))
    return TensorFit(pole, residue, constant, error, support)


def _supports(
    components: Callable[[np.ndarray], np.ndarray],
    support: np.ndarray,
    k0: float,
    z0: float,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Add support points at the errors' maxima until all samples fit; return supports, weights, samples x."""
    inside = (np.arange(_SAMPLES_PER_GAP) + 0.5) / _SAMPLES_PER_GAP
    while True:
        x = (support[:-1, None] + np.diff(support)[:, None] * inside).ravel()
        r, r_support = k0 * np.sinh(x), k0 * np.sinh(support)
        q, q_support = components(x)[:RZ], components(support)[:RZ]
        cauchy = 1.0 / ((r[:, None] - r_support) * (r[:, None] + r_support))
        column = r_support**2 + z0
        row = (r**2 + z0) / np.abs(q)
        loewner = (q[:, :, None] - q_support[:, None, :]) * (cauchy * column) * row[:, :, None]
        upper = np.linalg.qr(loewner.reshape(-1, support.size), mode="r")
        weight = column * np.linalg.svd(upper)[2][-1].conj()
        fitted = (cauchy @ (weight * q_support).T).T / (cauchy @ weight)
        error = np.abs(fitted / q - 1.0).max(axis=0).reshape(-1, _SAMPLES_PER_GAP)
        worst = error.max(axis=1)
        if worst.max() <= tolerance or support.size >= _MOST_TERMS:
            return support, weight, np.sort(np.concatenate([support, x]))
        # New supports in the gaps with the largest errors, at most an eighth of those there are.
        gaps = np.argsort(worst)[::-1][: max(1, support.size // 8)]
        gaps = gaps[worst[gaps] > max(0.5 * tolerance, 1e-3 * worst.max())]
        new = x.reshape(-1, _SAMPLES_PER_GAP)[gaps, error[gaps].argmax(axis=1)]
        support = np.sort(np.concatenate([support, new]))


def _residues(r: np.ndarray, q: np.ndarray, pole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return residues (5, p) and constants (3,) by least squares, weighted by 1/|q_zz| or 1/|q_tt|."""
    square = r[:, None] ** 2
    simple = 1.0 / (square - pole)
    with_constant = np.concatenate([simple, np.ones((r.size, 1))], axis=1)
    solved = [_least_squares(with_constant, q[part], q[part]) for part in (ZZ, RR, TT)]
    # ρ² q_d and ρ² q_c vanish at ρ = 0 by their form.
    through_zero = square * simple
    residue = [each[:-1] for each in solved]
    residue.append(_least_squares(through_zero, q[RR] - q[TT], q[TT]))
    residue.append(_least_squares(through_zero, r * q[RZ], r * q[ZZ]))
    return np.array(residue), np.array([each[-1] for each in solved])


def _least_squares(matrix: np.ndarray, right: np.ndarray, size: np.ndarray) -> np.ndarray:
    scaled = matrix / np.abs(size)[:, None]
    column = 1.0 / np.linalg.norm(scaled, axis=0)
    return np.asarray(np.linalg.lstsq(scaled * column, right / np.abs(size), rcond=None)[0] * column)


def _error(fit: TensorFit, r: np.ndarray, q: np.ndarray) -> float:
    zz, rr, tt, d, c = fit.parts(r)
    return float(
        max(
            np.abs(zz / q[ZZ] - 1.0).max(),
            np.abs(rr / q[RR] - 1.0).max(),
            np.abs(tt / q[TT] - 1.0).max(),
            np.abs((r**2 * d - (q[RR] - q[TT])) / q[TT]).max(),
            np.abs((r * c - q[RZ]) / q[ZZ]).max(),
        )
    )
