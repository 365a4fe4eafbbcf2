"""Direct evaluation of transfer functions at given frequencies and wavenumbers."""

from collections.abc import Callable, Iterable

import numpy as np

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.soil._kernels.strip import strip_compliances, strip_means
from railvib.soil.fits import GroundFits
from railvib.soil.quadrature import strip_compliance_by_quadrature, strip_mean_by_quadrature
from railvib.soil.strip import strip_compliance, strip_mean
from railvib.transfer._kernels.track import multiply_by_force
from railvib.transfer.track_response import track_response


class Evaluation:
    """Transfer functions of the rail and of the ground at some offsets by the semi-analytical model.

    Attributes
    ----------
    offsets
        Distances from the centre line, m, ascending from 0.
    compliance
        What the track follows in the last evaluation, C(β, 0) or the mean of C(β, y), on which it is put
        exactly between frequencies. None for a model without it, whose transfer functions are interpolated
        themselves.
    failed
        Frequencies without a good fit, Hz.
    """

    compliance: np.ndarray | None = None

    def __init__(self, fits: GroundFits, track: Track, offsets: Iterable[float], tolerance: float) -> None:
        self.fits = fits
        self.track = track
        self.offsets = np.unique([0.0, *offsets])
        self.tolerance = tolerance
        self.failed: set[float] = set()

    def row(self, receiver: Receiver) -> int:
        """Return the row that holds a receiver in the result of a call."""
        return 0 if receiver.offset is None else 1 + int(np.searchsorted(self.offsets, receiver.offset))

    def __call__(self, level: int, k: int, beta: np.ndarray) -> np.ndarray:
        """Return the rail and the ground at the offsets at frequency k of a level, (1 + offsets, n)."""
        f = float(blocks.frequency(level, k))
        fit = self.fits.at(level, k)
        b = self.track.half_width
        with cost.stage("transfer functions") as spent:
            if fit.error <= 1e-2 * self.tolerance:
                rational = fit.pole, fit.residue, fit.constant, b
                real, imag = strip_compliances(beta, *rational, self.offsets)
                mean = strip_means(beta, *rational) if self.track.follows_mean else None
            else:
                self.failed.add(f)
                compliance, mean = self._by_quadrature(f, beta)
                real, imag = compliance.real, compliance.imag
            under = (real[0], imag[0]) if mean is None else mean
            self.compliance = under[0] + 1j * under[1]
            rail, force = track_response(self.track, beta, 2.0 * np.pi * f, self.compliance)
            spent.evaluations += beta.size
            spent.kernel_calls += 1
            values = np.empty((1 + self.offsets.size, beta.size), complex)
            values[0] = rail
            multiply_by_force(real, imag, force.view(float), values[1:].view(float))
        return values

    def _by_quadrature(
        self, frequency: float, wavenumber: np.ndarray
    ) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray] | None]:
        """Return C(β, y) at the offsets, complex (offsets, n), and both parts of its mean if that counts."""
        ground, b, tolerance = self.fits.ground, self.track.half_width, 1e-3 * self.tolerance
        compliance = np.array(
            [
                strip_compliance_by_quadrature(ground, b, beta, self.offsets, frequency, tolerance)
                for beta in wavenumber
            ]
        ).T
        if not self.track.follows_mean:
            return compliance, None
        mean = np.array(
            [strip_mean_by_quadrature(ground, b, beta, frequency, tolerance) for beta in wavenumber]
        )
        return compliance, (mean.real, mean.imag)


Model = Callable[[GroundFits, Track, Iterable[float], float], Evaluation]
"""Returns an evaluation for given fits, track, offsets and tolerance."""


def compliance_error(fits: GroundFits, track: Track, reach: float, tolerance: float) -> float:
    """Return the largest relative error of C(β, y) against direct quadrature, at both ends of a class.

    For a track that follows it, also that of the mean over the strip.

    Parameters
    ----------
    fits, track
        The fits of the ground over a block, and the track.
    reach
        Farthest distance of the class from the centre line, m.
    tolerance
        Relative error allowed in the transfer functions.
    """
    ks = blocks.indices(fits.block, 0)
    offsets = np.array([0.0, reach])
    b = track.half_width
    worst = 0.0
    with cost.stage("certificate") as spent:
        for k in (int(ks[0]), int(ks[-1])):
            f = float(blocks.frequency(0, k))
            fit = fits.at(0, k)
            for beta in 2.0 * np.pi * f / fits.ground.slowest_speed * np.array([0.05, 0.7, 1.2]):
                direct = strip_compliance_by_quadrature(fits.ground, b, beta, offsets, f, 1e-2 * tolerance)
                compliance = strip_compliance(fit, np.array([beta]), b, offsets)[:, 0]
                size = np.maximum(np.abs(direct), 1e-8 * np.abs(direct[0]))
                worst = max(worst, float((np.abs(compliance - direct) / size).max()))
                if track.follows_mean:
                    mean = strip_mean_by_quadrature(fits.ground, b, beta, f, 1e-2 * tolerance)
                    worst = max(worst, abs(strip_mean(fit, np.array([beta]), b)[0] / mean - 1.0))
                spent.evaluations += 1
    return worst
