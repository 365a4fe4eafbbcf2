"""Compliance of the ground under a strip load, in closed form from the poles of its flexibility."""

import numpy as np

from railvib.soil._kernels.strip import strip_compliances, strip_means
from railvib.soil.rational_fit import RationalFit

_MEAN_REACH = 4000.0


def mean_fit_reach(half_width: float) -> float:
    """Return the wavenumber up to which a fit is needed for `strip_mean`, rad/m.

    [sin(γb)/(γb)]² does not change its sign, so that what a fit misses beyond its range does not average out
    as it does on the centre line: from 4000/b on it is below 1e-7 of the mean.
    """
    return _MEAN_REACH / half_width


def strip_compliance(
    fit: RationalFit, wavenumber: np.ndarray, half_width: float, offset: np.ndarray
) -> np.ndarray:
    """Return C(β, y) at the frequency of a fit, complex (offsets, wavenumbers) [m²/N].

    A value depends on its own wavenumber and offset only, not on what else is asked for.

    Parameters
    ----------
    fit
        The rational form of Q33.
    wavenumber
        β along the track, (n,), rad/m.
    half_width
        Half the contact width b, m.
    offset
        Distances y from the centre line, (m,), m, not negative.
    """
    real, imag = strip_compliances(wavenumber, fit.pole, fit.residue, fit.constant, half_width, offset)
    return np.asarray(real + 1j * imag)


def strip_mean(fit: RationalFit, wavenumber: np.ndarray, half_width: float) -> np.ndarray:
    """Return the mean of C(β, y) over the strip |y| ≤ b at the frequency of a fit, complex (n,) [m²/N].

    Parameters
    ----------
    fit, wavenumber, half_width
        As in `strip_compliance`; for 1e-7 the fit must reach up to `mean_fit_reach`.

    Notes
    -----
    The load and the mean weigh Q33 with sin(γb)/(γb) once each: (1/2π) ∫ Q33 [sin(γb)/(γb)]² dγ.
    """
    real, imag = strip_means(wavenumber, fit.pole, fit.residue, fit.constant, half_width)
    return np.asarray(real + 1j * imag)
