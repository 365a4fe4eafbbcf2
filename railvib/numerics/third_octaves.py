"""One-third-octave bands of IEC 61260-1 (base ten), and mean squares of spectra in them.

Exact midbands are 10^(n/10), edges lie at 10^(±1/20) of them; the nominal names (31.5) are labels only.
The same series serves frequencies in Hz and wavelengths in m.
"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railvib.errors import InputError

UNEVENNESS_REFERENCE = 1e-6
"""m, EN 15610."""

HALF_BAND = 10.0**0.05
"""Ratio of an edge to the midband."""

NOMINAL = ("1", "1.25", "1.6", "2", "2.5", "3.15", "4", "5", "6.3", "8")

STENCIL = 8
"""Neighbouring samples that carry the interpolating polynomial of one cell.

On the ripple of a train, sampled eight times in its period v/L, this leaves 0.001 dB; six samples would leave
0.008 dB, the trapezoidal rule 0.1 dB.
"""


def midbands(minimum: float, maximum: float) -> NDArray[np.float64]:
    """Return the exact midbands whose nominal or exact value lies between two limits, both included.

    Parameters
    ----------
    minimum, maximum
        Limits, nominal or exact, in Hz (or m for wavelengths).

    Raises
    ------
    InputError
        If the limits are not positive, finite and ascending, or no midband lies between them.
    """
    if not (0.0 < minimum <= maximum < math.inf):
        raise InputError(
            f"bands from {minimum:g} to {maximum:g}: limits must be positive, finite and ascending"
        )
    # A nominal value differs from the exact one by up to 0.04 of a band; 0.1 admits it and no neighbour.
    first = math.ceil(10.0 * math.log10(minimum) - 0.1)
    last = math.floor(10.0 * math.log10(maximum) + 0.1)
    if first > last:
        raise InputError(f"bands from {minimum:g} to {maximum:g}: no one-third-octave midband lies between")
    return np.asarray(10.0 ** (np.arange(first, last + 1) / 10.0))


def edges(midband: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the lower and upper edges of bands, in the unit of the midbands."""
    exact = np.asarray(midband, dtype=np.float64)
    return exact / HALF_BAND, exact * HALF_BAND


def nominal_label(midband: float) -> str:
    """Return the nominal name of a band, such as ``31.5``.

    >>> nominal_label(10**1.5)
    '31.5'
    """
    decade, step = divmod(round(10.0 * math.log10(midband)), 10)
    return f"{float(NOMINAL[step]) * 10.0**decade:g}"


def integrate(density: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return integrals of samples with step 1 between the first and the last, (...).

    Parameters
    ----------
    density
        Samples, at least `STENCIL` of them, not negative, (..., n).

    Notes
    -----
    Each cell is integrated by the polynomial through its `STENCIL` nearest samples. Where the result differs
    from the trapezoidal rule by more than a factor of two, the samples do not resolve the density, and the
    trapezoidal value stands: it cannot be negative.
    """
    polynomial = density @ _weights(density.shape[-1], STENCIL)
    trapezoidal = density @ _weights(density.shape[-1], 2)
    resolved = (polynomial > 0.5 * trapezoidal) & (polynomial < 2.0 * trapezoidal)
    return np.where(resolved, polynomial, trapezoidal)


@lru_cache(256)
def _weights(samples: int, stencil: int) -> NDArray[np.float64]:
    """Return the weights of a quadrature over samples with step 1 by polynomials of a stencil, (samples,)."""
    nodes = np.arange(stencil) - 0.5 * (stencil - 1)  # centred, for the sake of the powers
    powers = np.arange(1, stencil + 1)
    # Integrals of Lagrange's polynomials (columns) as coefficients of t, t², … (rows).
    primitive = np.linalg.inv(np.vander(nodes, increasing=True)) / powers[:, np.newaxis]
    cells = np.arange(samples - 1)
    first = np.clip(cells - (stencil - 1) // 2, 0, samples - stencil)
    inner = (cells - first + nodes[0])[:, np.newaxis]
    share = ((inner + 1.0) ** powers - inner**powers) @ primitive
    weights = np.zeros(samples)
    np.add.at(weights, first[:, np.newaxis] + np.arange(stencil), share)
    return weights
