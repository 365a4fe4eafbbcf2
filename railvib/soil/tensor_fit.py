"""Rational fit of the ground's flexibility tensor in ρ², all its parts on common poles.

    q_zz, q_rr, q_tt ≈ d + Σ_j a_j/(ρ² − z_j)        q_d, q_c ≈ Σ_j a_j/(ρ² − z_j)

of `railvib.soil.flexibility_tensor`. Common poles, because then every integral over γ needs the same
exponentials: those of q_zz, q_rr and q_tt together, by `railvib.soil.barycentric`. The residues come from
least squares. As in `railvib.soil.rational_fit` the fit is judged at wavenumbers that it has not seen. The
range reaches further: elements at the edges of the track are small, and feel large wavenumbers.
"""

from dataclasses import dataclass, replace

import numpy as np

from railvib.numerics import threads
from railvib.parameters.ground import Ground
from railvib.soil._kernels.layers import RR, RZ, TT, ZZ, surface_components
from railvib.soil.barycentric import Start, common_poles, fit_range, residues, residues_through_zero

_MOST_TERMS = 120


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
    start: Start
    """What a neighbouring frequency's fit starts from."""

    def parts(self, wavenumber: np.ndarray) -> np.ndarray:
        """Return the fitted q_zz, q_rr, q_tt, q_d, q_c at real wavenumbers (n,), complex (5, n)."""
        terms = 1.0 / (np.asarray(wavenumber, float)[:, None] ** 2 - self.pole)
        value = self.residue @ terms.T
        value[:3] += self.constant[:, None]
        return np.asarray(value)

    def scale(self, ratio: float) -> "TensorFit":
        """Return a half-space's fit at `ratio` ≥ 1 times the frequency: there ω q depends on ρ/ω only."""
        powers = np.array([1.0, 1.0, 1.0, -1.0, 0.0])[:, None]
        return TensorFit(
            self.pole * ratio**2,
            self.residue * ratio**powers,
            self.constant / ratio,
            self.error,
            self.start,
        )


def fit_tensor(
    ground: Ground,
    frequency: float,
    tolerance: float = 1e-8,
    start: Start | None = None,
    largest: float = 0.0,
) -> TensorFit:
    """Fit the flexibility tensor of a ground at one positive frequency.

    Parameters
    ----------
    ground
        The layered ground.
    frequency
        Frequency, Hz, positive.
    tolerance
        Relative error aimed at.
    start
        That of a neighbouring frequency's fit.
    largest
        Fit up to this wavenumber, rad/m, or further where the ground's waves ask for it.

    Returns
    -------
    TensorFit
        Its `error` tells whether it reached the tolerance; the caller decides what to do where it did not.
    """
    omega = 2.0 * np.pi * frequency
    stack = ground.stack()
    rigid = ground.base == "rigid"
    within = fit_range(ground, frequency, largest)

    def components(r: np.ndarray) -> np.ndarray:
        return np.asarray(surface_components(r, omega, stack, rigid))

    with threads.single():
        poles = common_poles(lambda r: components(r)[:RZ], within, tolerance, _MOST_TERMS, start)
        # At ρ = 0 the parts of order ρ and ρ² tell nothing.
        x = np.sort(np.concatenate([poles.seen.x, poles.unseen.x]))[1:]
        r = within.wavenumber(x)
        residue, constant = _residues(r, components(r), poles.pole)
        # Three places between the samples: an error as narrow as a resonance shows at one of them.
        unseen = within.wavenumber((x[:-1, None] + np.diff(x)[:, None] * [0.25, 0.5, 0.75]).ravel())
        fit = TensorFit(poles.pole, residue, constant, np.nan, poles.start)
        return replace(fit, error=_error(fit, unseen, components(unseen)))


def _residues(r: np.ndarray, q: np.ndarray, pole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return residues (5, p) and constants (3,), errors relative to |q_zz| or |q_tt|."""
    size = np.abs(q)
    residue, constant = zip(*(residues(r, q[part], size[part], pole) for part in (ZZ, RR, TT)), strict=True)
    through_zero = (
        residues_through_zero(r, q[RR] - q[TT], size[TT], pole),
        residues_through_zero(r, r * q[RZ], r * size[ZZ], pole),
    )
    return np.array([*residue, *through_zero]), np.array(constant)


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
