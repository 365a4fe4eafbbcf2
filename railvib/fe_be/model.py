"""Transfer functions of track and ground by the 2.5D FE/BE model, in the tables of `railvib.transfer.table`.

The model is that of `railvib.fe_be.coupling`; everything downstream of the tables is the same code as for
the semi-analytical model. Per block of frequencies the bed is condensed once, per frequency the flexibility
tensor is fitted once; a wavenumber then costs the strips' integrals and a small system.
"""

from collections.abc import Iterable
from functools import partial

import numpy as np
import numpy.typing as npt

from railvib import cost
from railvib.errors import InputError
from railvib.fe_be.boundary_elements import receiver_flexibility, strip_flexibility
from railvib.fe_be.coupling import Response, condense_columns, coupled_response, strip_edges
from railvib.fe_be.solid_bed import CondensedBed, SolidBed
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import threads
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.soil.barycentric import Start
from railvib.soil.fits import BlockFits, GroundFits, warm_or_cold
from railvib.soil.tensor_fit import TensorFit, fit_tensor
from railvib.transfer.evaluation import Evaluation
from railvib.transfer.nodes import node_range
from railvib.transfer.table import TransferBlock
from railvib.transfer.tabulate import transfer_blocks

_WAVENUMBER_TIMES_STRIP = 50.0
"""The tensor is fitted up to this over the width of the smallest strip."""
_STRIP_TOLERANCE = 1e-8
"""Of the fit for the strips: an error there is one of the forces, relative to them."""
_FIELD_TOLERANCE = 1e-10
"""Of the fit for receivers away from the track: the field there is small beside that under the track."""
_ACCEPTED = 1e-5
_NEAR = 0.5
"""Receivers up to so far from the track's edge, m, feel the large wavenumbers that its strips feel."""


def _fit(
    ground: Ground, largest: float, tolerance: float, frequency: float, start: Start | None = None
) -> TensorFit:
    """Return the tensor's fit up to a wavenumber.

    Raises
    ------
    ArithmeticError
        If it is not good enough to compute with.
    """
    fit = warm_or_cold(
        "tensor fit",
        lambda start: fit_tensor(ground, frequency, tolerance, start, largest),
        start,
        100.0 * tolerance,
    )
    if fit.error > _ACCEPTED:
        raise ArithmeticError(
            f"the ground's flexibility tensor at {frequency:g} Hz was fitted to {fit.error:.1e} only"
        )
    return fit


def _largest(track: Track, section: CrossSection) -> float:
    return _WAVENUMBER_TIMES_STRIP / float(np.diff(strip_edges(track, section)).min())


def _soil(
    beta: np.ndarray, edge: np.ndarray, offset: np.ndarray, strips: TensorFit, field: TensorFit
) -> tuple[np.ndarray, np.ndarray]:
    """Return the flexibilities of strips and receivers: far receivers from the fit for the field."""
    with cost.stage("boundary elements") as spent:
        soil = strip_flexibility(strips, beta, edge)
        receiver = np.empty((beta.size, offset.size, soil.shape[1]), complex)
        near = offset < edge[-1] + _NEAR
        for fit, part in ((strips, near), (field, ~near)):
            receiver[:, part] = receiver_flexibility(fit, beta, edge, offset[part])
        spent.evaluations += beta.size
        spent.kernel_calls += 3
    return soil, receiver


def fe_be_response(
    ground: Ground,
    track: Track,
    section: CrossSection,
    frequency: float,
    wavenumber: npt.ArrayLike,
    offsets: Iterable[float] = (),
) -> Response:
    """Return the response to a unit load on the rails, the bed factorised at every wavenumber.

    Parameters
    ----------
    ground, track, section
        The ground, the track on it, and the cross-section that stands for it.
    frequency
        Frequency, Hz, positive.
    wavenumber
        β along the track, rad/m, (n,).
    offsets
        Distances of receivers on the ground from the centre line, m, not negative.

    Raises
    ------
    InputError
        If the frequency is not positive, or an offset is negative.
    """
    if not (np.isfinite(frequency) and frequency > 0.0):
        raise InputError(f"frequency = {frequency} Hz: must be positive and finite")
    y = np.array([0.0, *(float(offset) for offset in offsets)])
    if not np.all(y >= 0.0):
        raise InputError(f"offset = {y.min()} m: must not be negative")
    beta = np.abs(np.atleast_1d(np.asarray(wavenumber, float)))
    omega = 2.0 * np.pi * frequency
    edge = strip_edges(track, section)
    strips = _fit(ground, _largest(track, section), _STRIP_TOLERANCE, frequency)
    field = _fit(ground, 0.0, _FIELD_TOLERANCE, frequency)
    soil, receiver = _soil(beta, edge, y, strips, field)
    if section.bed == "columns":
        bed = condense_columns(track, section, omega)
    else:
        with cost.stage("track sections"), threads.single():
            solid = SolidBed(track, section, edge)
            bed = np.array([solid.condense(b, omega) for b in beta])
    with cost.stage("coupling"), threads.single():
        response = coupled_response(track, section, beta, omega, bed, soil, receiver)
    return response._replace(ground=response.ground[1:])


class FeBeModel:
    """The FE/BE model of one ground and track over one block, for `railvib.transfer.tabulate`."""

    def __init__(
        self, ground: Ground, track: Track, section: CrossSection, block: int, refinement: int = 1
    ) -> None:
        self.track = track
        self.section = section
        self.edge = strip_edges(track, section)
        self.strips = BlockFits(
            ground, block, partial(_fit, ground, _largest(track, section), _STRIP_TOLERANCE)
        )
        self.field = BlockFits(ground, block, partial(_fit, ground, 0.0, _FIELD_TOLERANCE))
        frequency = blocks.frequency(0, blocks.indices(block, 0))
        self._bed = None
        if section.bed == "solid":
            _top, largest = node_range(ground, track, float(frequency[-1]), refinement)
            with threads.single():
                self._bed = CondensedBed(
                    SolidBed(track, section, self.edge), (float(frequency[0]), float(frequency[-1])), largest
                )

    def __call__(
        self, fits: GroundFits, track: Track, offsets: Iterable[float], tolerance: float
    ) -> Evaluation:
        """Return the evaluation at some offsets."""
        return _FeBeEvaluation(self, fits, track, offsets, tolerance)


class _FeBeEvaluation(Evaluation):
    def __init__(
        self,
        model: FeBeModel,
        fits: GroundFits,
        track: Track,
        offsets: Iterable[float],
        tolerance: float,
    ) -> None:
        super().__init__(fits, track, offsets, tolerance)
        self._model = model

    def __call__(self, level: int, k: int, beta: np.ndarray) -> np.ndarray:
        """Return the rail and the ground at the offsets, complex (1 + offsets, n)."""
        model = self._model
        omega = 2.0 * np.pi * float(blocks.frequency(level, k))
        soil, receiver = _soil(
            beta, model.edge, self.offsets, model.strips.at(level, k), model.field.at(level, k)
        )
        with cost.stage("coupling"), threads.single():
            bed = (
                condense_columns(model.track, model.section, omega)
                if model._bed is None
                else model._bed.at(beta, omega)
            )
            response = coupled_response(model.track, model.section, beta, omega, bed, soil, receiver)
        return np.concatenate([response.rail[None], response.ground])


def fe_be_blocks(
    ground: Ground,
    track: Track,
    section: CrossSection,
    block: int,
    receivers: Iterable[Receiver],
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> dict[Receiver, TransferBlock]:
    """Tabulate the FE/BE model's transfer functions, as `railvib.transfer.tabulate.transfer_blocks` does.

    Parameters
    ----------
    ground, track, section
        The ground, the track on it, and the cross-section that stands for it.
    block, receivers, tolerance, refinement
        As in `transfer_blocks`; the tolerance is that of interpolation, not of the model's mesh.
    """
    model = FeBeModel(ground, track, section, block, refinement)
    return transfer_blocks(ground, track, block, receivers, tolerance, refinement, model)
