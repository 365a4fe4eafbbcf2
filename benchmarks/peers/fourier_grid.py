"""The textbook way to the ground's compliance: Q33 on a uniform grid of β and γ, transformed over γ.

    C(β, y) = (1/π) ∫₀^∞ Q33(√(β² + γ²)) sin(γb)/(γb) cos(γy) dγ

Everything that makes the grid smaller or the transform cheaper is granted: evenness in β and γ, a cosine
transform of a suitable length, blocks of rows that fit into the cache, the coarsest spacing and the shortest
range that reach the required error, and sums for the few offsets where they are cheaper than the transform of
whole rows.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import fft

from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.soil._kernels.layers import surface_flexibilities
from railvib.soil.rational_fit import RationalFit
from railvib.soil.strip import strip_compliance
from railvib.transfer.nodes import largest_wavenumber
from railvib.transfer.track_response import track_response

OFFSETS = np.array([0.0, 8.0, 32.0, 100.0])
"""Distances from the centre line at which the ways are compared, m; multiples of 4 m, see _RANGE_STEP."""
ERROR = 1e-3
"""Largest error of the grid at every offset and wavenumber, relative to |C(β, 0)|."""
_RANGE_STEP = np.pi / 4.0
"""Ranges of γ are multiples of this, so that a transform's points y = jπ/range hit multiples of 4 m."""
_LONGEST_RANGE = 128 * _RANGE_STEP
_FINER = 2.0**0.25
_BLOCK_VALUES = 2**16
"""Values of a block of rows, a megabyte."""

Flexibility = Callable[[np.ndarray], np.ndarray]
"""Returns Q33 at wavenumbers (n,)."""


@dataclass(frozen=True)
class Grid:
    """A uniform grid in β ≥ 0 and γ ≥ 0; rad/m."""

    along: float
    """Spacing in β."""
    along_range: float
    across: float
    """Spacing in γ."""
    across_range: float

    @property
    def rows(self) -> int:
        """Number of wavenumbers β."""
        return int(np.ceil(self.along_range / self.along)) + 1

    @property
    def columns(self) -> int:
        """Number of wavenumbers γ: a fast length for a cosine transform, not below what the error needs."""
        return int(fft.next_fast_len(int(np.ceil(self.across_range / self.across)), real=True)) + 1

    @property
    def table_bytes(self) -> int:
        """Memory of the complex values on all of the grid."""
        return 16 * self.rows * self.columns

    @property
    def rows_together(self) -> int:
        """Rows of one block."""
        return max(1, _BLOCK_VALUES // self.columns)


def kernel(ground: Ground, omega: float) -> Flexibility:
    """Return railvib's compiled flexibility at one angular frequency in rad/s."""
    return partial(_flexibility, ground.stack(), ground.base == "rigid", omega)


def _flexibility(stack: np.ndarray, rigid: bool, omega: float, wavenumber: np.ndarray) -> np.ndarray:
    return np.asarray(surface_flexibilities(wavenumber, omega, stack, rigid))


def by_transform(flexibility: Flexibility, b: float, beta: np.ndarray, grid: Grid) -> np.ndarray:
    """Return C(β, y) at some rows of the grid and all `OFFSETS` by cosine transforms, (rows, offsets)."""
    values, step = _rows(flexibility, b, beta, grid)
    transformed = fft.dct(values, type=1, axis=1, overwrite_x=True)
    place = np.rint(OFFSETS * grid.across_range / np.pi).astype(int)
    last = grid.columns - 1
    columns = last - np.abs(last - place)  # the transform is even about its last point
    return np.asarray(transformed[:, columns] * (step / (2.0 * np.pi)))


def by_sums(
    flexibility: Flexibility, b: float, beta: np.ndarray, grid: Grid, cosines: np.ndarray
) -> np.ndarray:
    """Return the same as `by_transform` by sums with the `cosines` of the grid."""
    values, step = _rows(flexibility, b, beta, grid)
    real, imag = values.real @ cosines, values.imag @ cosines
    return np.asarray((real + 1j * imag) * (step / np.pi))


def cosines(grid: Grid) -> np.ndarray:
    """Return cos(γy) with the weights of the trapezoidal rule, (columns, offsets)."""
    gamma = np.linspace(0.0, grid.across_range, grid.columns)
    out = np.cos(gamma[:, None] * OFFSETS)
    out[[0, -1]] *= 0.5
    return np.asarray(out)


def _rows(flexibility: Flexibility, b: float, beta: np.ndarray, grid: Grid) -> tuple[np.ndarray, float]:
    """Return the integrand on some rows of the grid, and the step in γ."""
    gamma, step = np.linspace(0.0, grid.across_range, grid.columns, retstep=True)
    rho = np.sqrt(beta[:, None] ** 2 + gamma**2)
    values = flexibility(rho.ravel()).reshape(rho.shape)
    values *= np.sinc(gamma * (b / np.pi))
    return values, float(step)


def coarsest(ground: Ground, track: Track, frequency: float, fit: RationalFit) -> Grid:
    """Return the coarsest and shortest grid that reaches the error, judged by the closed form of a fit.

    Spacing and range in γ follow from the compliance at the most demanding wavenumbers β: around the surface
    wave's and at both ends. The spacing in β equals that in γ, since the axles of a train are as far apart as
    the receivers are from the track, and the periodic images are the same. The range in β leaves out no more
    of the rail's receptance than the error.
    """
    omega = 2.0 * np.pi * frequency
    b = track.half_width
    along_range = _range_along(track, omega, fit)
    slowest = omega / ground.slowest_speed
    beta = np.concatenate(
        [
            slowest * np.array([0.0, 0.1, 0.2, 0.3, 0.5, 0.8, 0.9, 0.95, 1.0, 1.05, 1.3]),
            [0.3 * along_range, along_range],
        ]
    )
    exact = closed_form(fit, b, beta)
    size = ERROR * np.abs(exact[:, :1])
    flexibility = kernel(ground, omega)

    def sums(spacing: float, largest: float) -> np.ndarray:
        """Return the trapezoidal sums up to every multiple of the step of ranges, (β, ranges, y)."""
        inside = int(np.ceil(_RANGE_STEP / spacing))
        ranges = int(np.ceil(largest / _RANGE_STEP))
        gamma = np.arange(inside * ranges + 1) * (_RANGE_STEP / inside)
        total = np.empty((beta.size, ranges, OFFSETS.size), complex)
        cosine = np.cos(gamma[:, None] * OFFSETS)
        for i, row in enumerate(beta):
            values = flexibility(np.sqrt(row**2 + gamma**2)) * np.sinc(gamma * (b / np.pi))
            terms = values[:, None] * cosine
            up_to = terms[1:].reshape(ranges, inside, -1).sum(axis=1).cumsum(axis=0)
            ends = 0.5 * (terms[0] - terms[inside::inside])  # both ends count half
            total[i] = (up_to + ends) * (_RANGE_STEP / inside / np.pi)
        return total

    def misses(total: np.ndarray) -> np.ndarray:
        """Return the largest error of each range over the error allowed."""
        return np.asarray((np.abs(total - exact[:, None]) / size[:, None]).max(axis=(0, 2)))

    # Waves from the next period decay with the least damped pole.
    waves = np.sqrt(fit.pole[np.abs(fit.pole) < (2.0 * slowest) ** 2])
    least = float(np.abs(waves.imag).min(initial=slowest))
    across = min(2.0 * np.pi / (OFFSETS.max() + np.log(10.0 / ERROR) / least), 0.04)
    short = np.flatnonzero(misses(sums(across, _LONGEST_RANGE)) <= 0.8)
    across_range = _RANGE_STEP * (1 + int(short[0])) if short.size else _LONGEST_RANGE
    while misses(sums(across, across_range))[-1] > 1.0:
        across /= _FINER
    while misses(sums(across * _FINER, across_range))[-1] <= 1.0:
        across *= _FINER
    grid = Grid(across, along_range, across, across_range)
    # A fast length makes the step a little finer, and images that cancelled may then add up.
    while (np.abs(by_transform(flexibility, b, beta, grid) - exact) > size).any():
        across /= _FINER**0.25
        grid = Grid(across, along_range, across, across_range)
    return grid


def closed_form(fit: RationalFit, b: float, beta: np.ndarray) -> np.ndarray:
    """Return C(β, y) at all `OFFSETS` by the poles of a fit, (β, offsets)."""
    return strip_compliance(fit, beta, b, OFFSETS).T


def _range_along(track: Track, omega: float, fit: RationalFit) -> float:
    """Return the β beyond which the rail's receptance has a share no larger than the error."""
    edge = np.concatenate([[0.0], np.geomspace(1e-4, 8.0 * largest_wavenumber(track), 4000)])
    beta = 0.5 * (edge[1:] + edge[:-1])
    rail, _ = track_response(track, beta, omega, closed_form(fit, track.half_width, beta)[:, 0])
    parts = rail * np.diff(edge)
    beyond = np.abs(np.cumsum(parts[::-1])[::-1]) / abs(parts.sum())
    return float(beta[np.flatnonzero(beyond > ERROR)[-1]])
