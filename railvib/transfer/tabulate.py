"""Making the tables of transfer functions: nodes, levels of frequencies, and the checks that they pass.

A table depends on its own inputs only. Receivers fall into classes by distance (8, 16, 32, … m). The panels
of a class are halved until the functions are resolved at its far end, so that the receivers of a class share
their nodes whichever of them are asked for. Each receiver then takes the first level of frequencies at which
interpolation between them passes a check against direct evaluation half-way.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.refinement import Panels, divide, halve, search_levels
from railvib.numerics.wavenumber_panels import nodes_between, series_tails
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import CENTRE, Receiver
from railvib.parameters.track import Track
from railvib.soil.fits import GroundFits
from railvib.soil.strip import mean_fit_reach
from railvib.transfer.evaluation import Evaluation, Model, compliance_error
from railvib.transfer.intensity import square_level
from railvib.transfer.interpolation_error import HalfwayCheck, halfway_places
from railvib.transfer.nodes import Nodes, node_range
from railvib.transfer.receiver_classes import VALUES_AT_ONCE, distance_class
from railvib.transfer.samples import Samples
from railvib.transfer.table import SharedTable, TransferBlock

_MOST_HALVINGS = 12
_RESOLVED = 1e-2
"""Size of a panel's last Legendre coefficients, over tolerance times peak, that resolves it."""
_CHECKS = 5
"""Places between the frequencies of a level at which a table is checked."""


def transfer_blocks(
    ground: Ground,
    track: Track,
    block: int,
    receivers: Iterable[Receiver],
    tolerance: float = 1e-4,
    refinement: int = 1,
    evaluation: Model | None = None,
) -> dict[Receiver, TransferBlock]:
    """Tabulate the transfer functions of several receivers over one block of frequencies.

    Parameters
    ----------
    ground, track
        The ground, and the track on it.
    block
        Index of the block, see `railvib.numerics.frequency_blocks`.
    receivers
        The rail, and the ground at offsets.
    tolerance
        Relative error allowed where a function exceeds 1e-8 of its peak (for the ground, of that at y = 0).
    refinement
        For studies of convergence: 2 halves the steps in frequency and the panels in wavenumber that the
        tolerance asks for, and doubles the range of wavenumbers; 4 does so twice.
    evaluation
        Evaluates the transfer functions; without it the semi-analytical model.

    Returns
    -------
    dict
        A `TransferBlock` per receiver, the same whichever others are asked for with it.
    """
    return {
        receiver: table
        for tables in transfer_blocks_by_class(
            ground, track, block, receivers, tolerance, refinement, evaluation
        )
        for receiver, table in tables.items()
    }


def transfer_blocks_by_class(
    ground: Ground,
    track: Track,
    block: int,
    receivers: Iterable[Receiver],
    tolerance: float = 1e-4,
    refinement: int = 1,
    evaluation: Model | None = None,
) -> Iterator[dict[Receiver, TransferBlock]]:
    """Yield what `transfer_blocks` returns class by class, some receivers of a class at a time.

    So not all tables are in memory at once. Tables of a class that have the same frequencies refer to one
    `SharedTable`.
    """
    reach = mean_fit_reach(track.half_width) if track.follows_mean else 0.0
    fits = GroundFits(ground, block, 1e-6 * tolerance, reach)
    model = evaluation or Evaluation
    classes: dict[float, set[Receiver]] = {}
    for receiver in receivers:
        classes.setdefault(distance_class(receiver), set()).add(receiver)
    for reach, members in sorted(classes.items()):
        nodes = _resolve_nodes(model(fits, track, (0.0, reach), tolerance), tolerance, refinement)
        receiver_class = _ReceiverClass(compliance_error(fits, track, reach, tolerance))
        ordered = sorted(members, key=lambda receiver: receiver.rank)
        for first in range(0, len(ordered), VALUES_AT_ONCE):
            samples = Samples(model, fits, track, nodes, tolerance)
            yield from _tables(samples, ordered[first : first + VALUES_AT_ONCE], receiver_class, refinement)


def _resolve_nodes(evaluate: Evaluation, tolerance: float, refinement: int) -> Nodes:
    """Halve panels until the last Legendre coefficients of every function are small, at three frequencies."""
    ground, block = evaluate.fits.ground, evaluate.fits.block
    ks = blocks.indices(block, 0)[[0, blocks.HALO + blocks.STEPS // 2, -1]]
    frequency = blocks.frequency(0, ks)
    top, largest = node_range(ground, evaluate.track, float(frequency[-1]), refinement)
    first = np.unique(
        [0.0, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, *(1.0 / (speed * top) for speed in ground.wave_speeds())]
    )
    peak = np.zeros((ks.size, 1 + evaluate.offsets.size))

    def check(panels: Panels) -> tuple[np.ndarray, np.ndarray]:
        # Each panel alone, between its own two edges.
        edge = Nodes(top, largest, panels.edges.ravel()).panel_edges(frequency)
        beta = nodes_between(edge.reshape(ks.size, -1, 2)).reshape(ks.size, -1)
        values = np.array([evaluate(0, int(k), row) for k, row in zip(ks, beta, strict=True)])
        np.maximum(peak, np.abs(values).max(axis=2), out=peak)
        bad = series_tails(values) > _RESOLVED * tolerance * peak[..., None]
        return panels.low, np.asarray(bad.any(axis=(0, 1)))

    low = np.concatenate([part for _panels, part in halve(Panels.between(first), check, _MOST_HALVINGS)])
    edge = np.append(np.sort(low), 2.0)
    return Nodes(top, largest, divide(edge, refinement))


class _ReceiverClass:
    """What the tables of a class share, and their check, at each level."""

    def __init__(self, compliance_error: float) -> None:
        self._compliance_error = compliance_error
        self._shared: dict[int, SharedTable] = {}
        self._checks: dict[int, HalfwayCheck] = {}

    def check(self, samples: Samples, level: int) -> HalfwayCheck:
        """Return the check of a level's tables."""
        if level not in self._checks:
            places = halfway_places(samples.fits.block, level, _CHECKS)
            self._checks[level] = HalfwayCheck(
                places,
                samples.nodes,
                samples.track,
                samples.compliance(level, places.row),
                samples.at(level + 1, places.place, CENTRE),
            )
        return self._checks[level]

    def shared(self, samples: Samples, level: int) -> SharedTable:
        """Return what the tables of a level share."""
        if level not in self._shared:
            fits, nodes = samples.fits, samples.nodes
            ks = blocks.indices(fits.block, level)
            frequency = blocks.frequency(level, ks)
            compliance = samples.compliance(level, ks)
            self._shared[level] = SharedTable(
                frequency=frequency,
                wavenumber=nodes.wavenumber(frequency),
                compliance=None if compliance is None else np.array(compliance),
                **_rational_form(fits, level, ks),
                quadrature=tuple(f for f in frequency.tolist() if f in samples.failed),
                block=fits.block,
                level=level,
                nodes=nodes,
                compliance_error=self._compliance_error,
            )
        return self._shared[level]


def _rational_form(fits: GroundFits, level: int, ks: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fits of a level as the arrays of a table, terms that a frequency lacks filled with NaN."""
    by_frequency = [fits.at(level, int(k)) for k in ks]
    terms = max(fit.pole.size for fit in by_frequency)
    pole = np.full((ks.size, terms), complex(np.nan, np.nan))
    residue = pole.copy()
    for row, fit in enumerate(by_frequency):
        pole[row, : fit.pole.size] = fit.pole
        residue[row, : fit.pole.size] = fit.residue
    return {
        "pole": pole,
        "residue": residue,
        "constant": np.array([fit.constant for fit in by_frequency]),
        "fit_error": np.array([fit.error for fit in by_frequency]),
    }


def _tables(
    samples: Samples, receivers: Sequence[Receiver], receiver_class: _ReceiverClass, refinement: int
) -> Iterator[dict[Receiver, TransferBlock]]:
    """Tabulate receivers, each at the first level that passes its check, or one beyond it; level by level."""
    block = samples.fits.block

    def tabulate(
        level: int, pending: Sequence[Receiver]
    ) -> Callable[[Receiver, bool], tuple[TransferBlock | None, bool]]:
        samples.evaluate(level, blocks.indices(block, level), pending)
        samples.evaluate(level + 1, blocks.halfway_indices(block, level, _CHECKS), pending)

        def check(receiver: Receiver, required: bool) -> tuple[TransferBlock | None, bool]:
            table = _table(samples, receiver_class, level, receiver, required)
            return table, table is not None

        return check

    start = dict.fromkeys(receivers, 0)
    for tables in search_levels(start, tabulate, beyond=int(np.log2(refinement))):
        yield {receiver: table for receiver, (_level, table) in tables.items() if table is not None}


def _table(
    samples: Samples, receiver_class: _ReceiverClass, level: int, receiver: Receiver, required: bool
) -> TransferBlock | None:
    """Return the table of a receiver at a level; None if it fails its check, unless it is required."""
    track, tolerance = samples.track, samples.tolerance
    check = receiver_class.check(samples, level)
    distance = receiver.distance(track.half_width)
    rows = samples.at(level, check.places.row, receiver)
    direct = np.array(samples.at(level + 1, check.places.place, receiver))
    reference = check.reference_slowness(receiver, distance, rows, direct, tolerance, required)
    if reference is None:
        return None
    slowness, error = reference
    table = TransferBlock(
        receiver_class.shared(samples, level),
        transfer=np.array(samples.at(level, blocks.indices(samples.fits.block, level), receiver)),
        receiver=receiver.name,
        offset=receiver.offset_m,
        distance=distance,
        square_level=level,
        reference_slowness=tuple(slowness.tolist()),
        interpolation_error=error,
    )
    negligible = check.negligible(receiver, direct)
    finer = square_level(table, track, check.places.place, direct, negligible, tolerance)
    return replace(table, square_level=finer)
