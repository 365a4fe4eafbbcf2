"""Rational fit of the ground's flexibility in ρ², once per soil and frequency.

    Q33(ρ) ≈ d + Σ_j a_j/(ρ² − z_j)

The poles come from `railvib.soil.barycentric`, residues and constant from least squares over the samples. The
fit is judged at wavenumbers that it has not seen: that error is its certificate. See docs/theory/ground.md.
"""

from dataclasses import dataclass

import numpy as np

from railvib.numerics import threads
from railvib.parameters.ground import Ground
from railvib.soil._kernels.barycentric import partial_fraction_errors
from railvib.soil._kernels.layers import surface_flexibilities
from railvib.soil.barycentric import Start, common_poles, fit_range, residues

_MOST_TERMS = 220


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
    start: Start
    """What a neighbouring frequency's fit starts from."""

    def flexibility(self, wavenumber: np.ndarray) -> np.ndarray:
        """Return the fitted Q33 at real wavenumbers (n,), m/Pa."""
        r = np.asarray(wavenumber, float)
        return np.asarray(self.constant + (self.residue / (r[:, None] ** 2 - self.pole)).sum(axis=1))

    def scale(self, ratio: float) -> "RationalFit":
        """Return a half-space's fit at `ratio` times the frequency: its Q33 is a function of ρ/ω, over ω."""
        return RationalFit(
            self.pole * ratio**2, self.residue * ratio, self.constant / ratio, self.error, self.start
        )


def fit_flexibility(
    ground: Ground,
    frequency: float,
    tolerance: float = 1e-9,
    start: Start | None = None,
    largest: float = 0.0,
) -> RationalFit:
    """Fit Q33 of a ground at one positive frequency.

    Parameters
    ----------
    ground
        The layered ground.
    frequency
        Frequency, Hz, positive.
    tolerance
        Relative error aimed at, everywhere in `railvib.soil.barycentric.fit_range`.
    start
        That of a neighbouring frequency's fit.
    largest
        Fit up to this wavenumber, rad/m, or further where the ground's waves ask for it.

    Returns
    -------
    RationalFit
        Its `error` tells whether it reached the tolerance; the caller decides what to do where it did not.
    """
    omega = 2.0 * np.pi * frequency
    stack = ground.stack()
    rigid = ground.base == "rigid"
    within = fit_range(ground, frequency, largest)

    def flexibility(r: np.ndarray) -> np.ndarray:
        return np.asarray(surface_flexibilities(r, omega, stack, rigid))[np.newaxis]

    with threads.single():
        poles = common_poles(flexibility, within, tolerance, _MOST_TERMS, start)
        (f,) = poles.seen.value
        residue, constant = residues(within.wavenumber(poles.seen.x), f, np.abs(f), poles.pole)
        error = partial_fraction_errors(
            within.wavenumber(poles.unseen.x), poles.unseen.value[0], poles.pole, residue, constant
        )
    return RationalFit(poles.pole, residue, constant, float(error.max()), poles.start)
