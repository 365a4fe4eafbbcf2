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


def band_mean_squares(frequency: ArrayLike, psd: ArrayLike, midband: ArrayLike) -> NDArray[np.float64]:
    """Return the integral of one-sided power spectral densities between the edges of bands.

    Parameters
    ----------
    frequency
        Uniform grid in Hz, shape (F,), at least from the lowest lower edge to the highest upper edge.
    psd
        Densities per Hz, shape (..., F), not negative.
    midband
        Exact midbands in Hz, shape (B,).

    Returns
    -------
    Mean squares, shape (..., B).

    Raises
    ------
    InputError
        If the grid is not uniform, has fewer than 8 samples or does not cover the bands, or the densities do
        not fit the grid, are negative or not finite.

    Notes
    -----
    Each cell between two samples is integrated by the polynomial of degree 7 through its eight nearest
    samples. It is local on purpose: a spline, or a difference of running integrals, spreads the rounding
    and ringing of the largest values over a spectrum that spans many decades. Where a band is not
    resolved, so that this differs from the trapezoidal rule by more than a factor of two, the trapezoidal
    value stands: it cannot be negative.
    """
    grid = np.asarray(frequency, dtype=np.float64)
    density = np.asarray(psd, dtype=np.float64)
    middle = np.atleast_1d(np.asarray(midband, dtype=np.float64))
    step = _uniform_step(grid, density)
    lower, upper = edges(middle)
    slack = 1e-9 * step
    if lower.min() < grid[0] - slack or upper.max() > grid[-1] + slack:
        raise InputError(
            f"frequency from {grid[0]:.6g} to {grid[-1]:.6g} Hz: must cover the bands' edges, "
            f"{lower.min():.6g} to {upper.max():.6g} Hz"
        )
    starts, stops = (lower - grid[0]) / step, (upper - grid[0]) / step
    bounds = tuple(starts.tolist()), tuple(stops.tolist())
    polynomial = density @ _weights(*bounds, grid.size, STENCIL) * step
    trapezoidal = density @ _weights(*bounds, grid.size, 2) * step
    resolved = (polynomial > 0.5 * trapezoidal) & (polynomial < 2.0 * trapezoidal)
    return np.where(resolved, polynomial, trapezoidal)


def _uniform_step(grid: NDArray[np.float64], density: NDArray[np.float64]) -> float:
    if grid.ndim != 1 or grid.size < STENCIL:
        raise InputError(f"frequency of shape {grid.shape}: must be one axis of at least {STENCIL} samples")
    if density.shape[-1:] != grid.shape:
        raise InputError(
            f"psd of shape {density.shape}: its last axis must fit the frequency's {grid.size} samples"
        )
    step = float(grid[-1] - grid[0]) / (grid.size - 1)
    if not step > 0.0 or np.abs(np.diff(grid) - step).max() > 1e-6 * step:
        raise InputError(f"frequency: must be a uniform ascending grid, here steps are near {step:.6g} Hz")
    if not np.all(np.isfinite(density)) or np.any(density < 0.0):
        raise InputError("psd: must be finite and not negative")
    return step


@lru_cache(8)
def _weights(
    starts: tuple[float, ...], stops: tuple[float, ...], samples: int, stencil: int
) -> NDArray[np.float64]:
    """Return the quadrature weights, shape (sample, band), of intervals given in steps of the grid."""
    nodes = np.arange(stencil) - 0.5 * (stencil - 1)  # centred, for the sake of the powers
    powers = np.arange(1, stencil + 1)
    # Integrals of Lagrange's polynomials (columns) as coefficients of t, t², … (rows).
    primitive = np.linalg.inv(np.vander(nodes, increasing=True)) / powers[:, np.newaxis]
    weights = np.zeros((len(starts), samples))
    for row, start, stop in zip(weights, starts, stops, strict=True):
        cells = np.arange(max(math.floor(start), 0), min(math.ceil(stop), samples - 1))
        first = np.clip(cells - (stencil - 1) // 2, 0, samples - stencil)
        inner = np.maximum(cells, start) - first + nodes[0]
        outer = np.minimum(cells + 1, stop) - first + nodes[0]
        share = (outer[:, np.newaxis] ** powers - inner[:, np.newaxis] ** powers) @ primitive
        np.add.at(row, first[:, np.newaxis] + np.arange(stencil), share)
    return np.ascontiguousarray(weights.T)
