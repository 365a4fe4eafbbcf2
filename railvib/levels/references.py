"""Reference values of levels in decibels."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

VELOCITY = 1e-9
"""m/s, ISO 1683:2015."""

VELOCITY_DIN = 5e-8
"""m/s, ISO 1683:1983, as in DIN 45672-2."""

VELOCITY_US = 2.54e-8
"""m/s: one micro-inch per second, of the VdB used in the United States (FTA)."""

ACCELERATION = 1e-6
"""m/s², ISO 1683."""

FORCE_DENSITY = 1.0
"""N/√m."""

LINE_MOBILITY = VELOCITY / FORCE_DENSITY
"""(m/s)/(N/√m), of transfer mobilities of a line source."""

POUND = 4.4482216152605
"""N."""

FOOT = 0.3048
"""m."""

FORCE_DENSITY_US = POUND / FOOT**0.5
"""N/√m: one pound per square root of a foot."""

LINE_MOBILITY_US = VELOCITY_US / FORCE_DENSITY_US
"""(m/s)/(N/√m): one micro-inch per second and pound per square root of a foot."""


def level(mean_square: ArrayLike, reference: float) -> NDArray[np.float64]:
    """Return 10 lg(mean square / reference²) in dB; −∞ for a mean square of 0.

    Parameters
    ----------
    mean_square
        Mean squares in the square of the reference's unit.
    reference
        Reference value, such as `VELOCITY`.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 * np.log10(np.asarray(mean_square, dtype=np.float64) / reference**2))


def mean_square(level: ArrayLike, reference: float) -> NDArray[np.float64]:
    """Return the mean square of a level in dB, in the square of the reference's unit."""
    return np.asarray(reference**2 * 10.0 ** (np.asarray(level, dtype=np.float64) / 10.0))
