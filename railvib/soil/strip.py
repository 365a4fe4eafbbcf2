"""Compliance of the ground under a strip load, in closed form from the poles of its flexibility."""

import numpy as np

from railvib.soil._kernels.strip import strip_compliances
from railvib.soil.rational_fit import RationalFit


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
