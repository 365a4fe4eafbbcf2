"""Making the tables of transfer functions: nodes, levels of frequencies, and the checks that they pass.

A table depends on its own inputs only. Receivers fall into classes by distance (8, 16, 32, … m); the panels
of a class are halved until the functions are resolved at its far end, so that the receivers of one class
share their nodes, and none depends on which others were asked for. Each receiver then takes the first level
of frequencies at which interpolation between them passes a check against direct evaluation half-way.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.wavenumber_panels import nodes_between, unresolved
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.soil.fits import GroundFits
from railvib.soil.quadrature import strip_compliance_by_quadrature
from railvib.soil.strip import strip_compliances
from railvib.transfer.intensity import square_level
from railvib.transfer.interpolation_error import Halfway
from railvib.transfer.nodes import TOP, Nodes
from railvib.transfer.table import Receiver, SharedTable, TransferBlock
from railvib.transfer.track_response import times_force, track_response

MOST_LEVELS = 6
TIGHTEST, LOOSEST = 1e-6, 1e-2
"""Tolerances that can be asked for; the rational fits are asked for a millionth of them."""
_MOST_HALVINGS = 12
_CHECKS = 5
VALUES_AT_ONCE = 32
"""Receivers whose values are computed together; their tables of one level are handed on together."""


def largest_wavenumber(track: Track, refinement: int = 1) -> float:
    """Return β beyond which the rail on its pads carries the load alone, rad/m: EI β⁴ is 2000 pads."""
    return float(refinement * (2000.0 * track.pad_stiffness / track.rail_bending_stiffness) ** 0.25)


def distance_class(receiver: Receiver) -> float:
    """Return the farthest distance of the receiver's class, m: 8, 16, 32, …; 8 for the rail."""
    if receiver == "rail":
        return 8.0
    return float(8.0 * 2.0 ** max(np.ceil(np.log2(max(float(receiver), 1.0) / 8.0)), 0.0))


def transfer_blocks(
    ground: Ground,
    track: Track,
    block: int,
    receivers: Iterable[Receiver],
    tolerance: float = 1e-4,
    refinement: int = 1,
    evaluation: "Model | None" = None,
) -> dict[Receiver, TransferBlock]:
    """Tabulate the transfer functions of several receivers over one block of frequencies.

    Parameters
    ----------
    ground, track
        The ground, and the track on it.
    block
        Index of the block, see `railvib.numerics.frequency_blocks`.
    receivers
        ``"rail"`` and distances from the centre line in m.
    tolerance
        Relative error allowed where a function exceeds 1e-8 of its peak (for the ground, of that at y = 0).
    refinement
        For studies of convergence: 2 halves the steps in frequency and the panels in wavenumber that the
        tolerance asks for, and doubles the range of wavenumbers; 4 does so twice.
    evaluation
        What evaluates the transfer functions; without it the semi-analytical model.

    Returns
    -------
    dict
        A `TransferBlock` per receiver, the same whichever others were asked for with it.
    """
    made: dict[Receiver, TransferBlock] = {}
    for members in transfer_blocks_by_class(
        ground, track, block, receivers, tolerance, refinement, evaluation
    ):
        made.update(members)
    return made


def transfer_blocks_by_class(
    ground: Ground,
    track: Track,
    block: int,
    receivers: Iterable[Receiver],
    tolerance: float = 1e-4,
    refinement: int = 1,
    evaluation: "Model | None" = None,
) -> Iterator[dict[Receiver, TransferBlock]]:
    """Yield what `transfer_blocks` returns class by class, some receivers of a class at a time.

    So not all tables are in memory at once. Tables of a class that have the same frequencies refer to one
    `SharedTable`.
    """
    fits = GroundFits(ground, block, 1e-6 * tolerance)
    model = evaluation or Evaluation
    classes: dict[float, set[Receiver]] = {}
    for receiver in receivers:
        classes.setdefault(distance_class(receiver), set()).add(receiver)
    for reach, members in sorted(classes.items()):
        nodes = _resolved_nodes(model(fits, track, (0.0, reach), tolerance), tolerance, refinement)
        common = _Common(_compliance_error(fits, track, reach, tolerance))
        ordered = sorted(members, key=lambda each: -1.0 if each == "rail" else float(each))
        for first in range(0, len(ordered), VALUES_AT_ONCE):
            samples = _Samples(model, fits, track, nodes, tolerance)
            yield from _tables(samples, ordered[first : first + VALUES_AT_ONCE], common, refinement)


class Evaluation:
    """Direct evaluation of the transfer functions of the rail and of the ground at some offsets.

    Attributes
    ----------
    offsets
        Distances from the centre line, m, ascending from 0.
    compliance
        C(β, 0) of the last evaluation, on which the track is put exactly between frequencies; None for a
        model that knows no such thing, whose transfer functions are interpolated themselves.
    failed
        Frequencies at which there was no good fit, Hz.
    """

    compliance: np.ndarray | None = None

    def __init__(self, fits: GroundFits, track: Track, offsets: Iterable[float], tolerance: float) -> None:
        self.fits = fits
        self.track = track
        self.offsets = np.unique([0.0, *offsets])
        self.tolerance = tolerance
        self.failed: set[float] = set()

    def row(self, receiver: Receiver) -> int:
        """Return the row of a receiver in what a call returns."""
        return 0 if receiver == "rail" else 1 + int(np.searchsorted(self.offsets, float(receiver)))

    def __call__(self, level: int, k: int, beta: np.ndarray) -> np.ndarray:
        """Return the rail and the ground at the offsets at frequency k of a level, (1 + offsets, n)."""
        f = float(blocks.frequency(level, k))
        fit = self.fits.at(level, k)
        b = self.track.half_width
        with cost.stage("transfer functions") as spent:
            if fit.error <= 1e-2 * self.tolerance:
                real, imag = strip_compliances(beta, fit.pole, fit.residue, fit.constant, b, self.offsets)
            else:
                self.failed.add(f)
                compliance = np.array(
                    [
                        strip_compliance_by_quadrature(
                            self.fits.ground, b, each, self.offsets, f, 1e-3 * self.tolerance
                        )
                        for each in beta
                    ]
                ).T
                real, imag = compliance.real, compliance.imag
            self.compliance = real[0] + 1j * imag[0]
            rail, force = track_response(self.track, beta, 2.0 * np.pi * f, self.compliance)
            spent.evaluations += beta.size
            spent.kernel_calls += 1
            values = np.empty((1 + self.offsets.size, beta.size), complex)
            values[0] = rail
            times_force(real, imag, force.view(float), values[1:].view(float))
        return values


Model = Callable[[GroundFits, Track, Iterable[float], float], Evaluation]
"""Makes an evaluation for given fits, track, offsets and tolerance."""


class _Samples:
    """Direct values on the nodes of a class, each frequency and receiver computed once."""

    COMPLIANCE = "compliance"
    """Name of C(β, 0) among the receivers."""

    def __init__(self, model: Model, fits: GroundFits, track: Track, nodes: Nodes, tolerance: float) -> None:
        self.fits = fits
        self.track = track
        self.nodes = nodes
        self.tolerance = tolerance
        self.failed: set[float] = set()
        self._model = model
        self._known: dict[tuple[int, int], dict[Receiver, np.ndarray]] = {}
        self._found: dict[tuple[int, bytes], list[dict[Receiver, np.ndarray]]] = {}

    def evaluate(self, level: int, ks: np.ndarray, receivers: list[Receiver]) -> None:
        """Compute what is missing of receivers at frequencies of a level, and of the ground at 0."""
        wanted: dict[tuple[Receiver, ...], list[int]] = {}
        for k in map(int, ks):
            known = self._known.setdefault(_coarsest(level, k), {})
            missing = tuple(each for each in receivers if each not in known)
            if missing:
                wanted.setdefault(missing, []).append(k)
        for missing, some in wanted.items():
            offsets = [float(each) for each in missing if each != "rail"]
            evaluate = self._model(self.fits, self.track, offsets, self.tolerance)
            rows = [(each, evaluate.row(each)) for each in (0.0, *missing)]
            beta = self.nodes.wavenumber(blocks.frequency(level, np.array(some)))
            for k, own in zip(some, beta, strict=True):
                values = evaluate(level, k, own)
                known = self._known[_coarsest(level, k)]
                known.update({each: values[row] for each, row in rows})
                if evaluate.compliance is not None:
                    known[self.COMPLIANCE] = evaluate.compliance
            self.failed |= evaluate.failed

    def at(self, level: int, ks: np.ndarray, receiver: Receiver) -> list[np.ndarray]:
        """Return the values of a receiver, or C(β, 0), at frequencies of a level, each on the nodes."""
        key = level, ks.tobytes()
        if key not in self._found:
            self._found[key] = [self._known[_coarsest(level, k)] for k in map(int, ks)]
        return [known[receiver] for known in self._found[key]]

    @property
    def know_compliance(self) -> bool:
        """Whether the model knows C(β, 0)."""
        return any(self.COMPLIANCE in known for known in self._known.values())


def _coarsest(level: int, k: int) -> tuple[int, int]:
    """Return the lowest level that has a frequency, and its index there."""
    while level > 0 and k % 2 == 0:
        level, k = level - 1, k // 2
    return level, k


class _Common:
    """What the tables of a class have in common at each level."""

    def __init__(self, certificate: float) -> None:
        self._certificate = certificate
        self._tables: dict[int, SharedTable] = {}
        self._halfway: dict[int, Halfway] = {}

    def halfway(self, samples: _Samples, level: int) -> Halfway:
        """Return the places of a level's check."""
        if level not in self._halfway:
            known = samples.know_compliance
            made = Halfway(
                samples.nodes, samples.fits.block, level, samples.track if known else None, _CHECKS
            )
            made.put_on(
                samples.at(level, made.row, samples.COMPLIANCE) if known else [],
                samples.at(level + 1, made.place, 0.0),
            )
            self._halfway[level] = made
        return self._halfway[level]

    def table(self, samples: _Samples, level: int) -> SharedTable:
        """Return what the tables of a level share."""
        if level not in self._tables:
            fits, nodes = samples.fits, samples.nodes
            ks = blocks.indices(fits.block, level)
            frequency = blocks.frequency(level, ks)
            known = samples.know_compliance
            self._tables[level] = SharedTable(
                frequency=frequency,
                wavenumber=nodes.wavenumber(frequency),
                compliance=np.array(samples.at(level, ks, samples.COMPLIANCE)) if known else None,
                **_rational_form(fits, level, ks),
                quadrature=tuple(f for f in frequency.tolist() if f in samples.failed),
                block=fits.block,
                level=level,
                nodes=nodes,
                compliance_error=self._certificate,
            )
        return self._tables[level]


def _resolved_nodes(evaluate: Evaluation, tolerance: float, refinement: int) -> Nodes:
    """Halve panels until the last Legendre coefficients of every function are small, at three frequencies."""
    ground, block = evaluate.fits.ground, evaluate.fits.block
    ks = blocks.indices(block, 0)[[0, blocks.HALO + blocks.STEPS // 2, -1]]
    frequency = blocks.frequency(0, ks)
    top = TOP / ground.slowest_speed
    largest = max(
        largest_wavenumber(evaluate.track, refinement), 2.0 * 2.0 * np.pi * float(frequency[-1]) * top
    )
    edge = np.unique(
        [0.0, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, *(1.0 / (speed * top) for speed in ground.wave_speeds())]
    )
    pending = np.stack([edge[:-1], edge[1:]], axis=1)
    finished: list[np.ndarray] = []
    peak = np.zeros((ks.size, 1 + evaluate.offsets.size))
    for _ in range(_MOST_HALVINGS):
        # Each pending panel alone, between its own two edges.
        ends = Nodes(top, largest, pending.ravel()).panel_edges(frequency).reshape(ks.size, -1, 2)
        beta = nodes_between(ends).reshape(ks.size, -1)
        values = np.array([evaluate(0, int(k), row) for k, row in zip(ks, beta, strict=True)])
        peak = np.maximum(peak, np.abs(values).max(axis=2))
        bad = (unresolved(values) > 1e-2 * tolerance * peak[..., None]).any(axis=(0, 1))
        finished.append(pending[~bad])
        middle = pending[bad].mean(axis=1)
        pending = np.concatenate(
            [np.stack([pending[bad, 0], middle], axis=1), np.stack([middle, pending[bad, 1]], axis=1)]
        )
        if not bad.any():
            break
    found = np.append(np.sort(np.concatenate([*finished, pending])[:, 0]), 2.0)
    fine = np.interp(np.arange(refinement * (found.size - 1) + 1) / refinement, np.arange(found.size), found)
    return Nodes(top, largest, fine)


def _tables(
    samples: _Samples, receivers: list[Receiver], common: _Common, refinement: int
) -> Iterator[dict[Receiver, TransferBlock]]:
    """Tabulate receivers, each at the first level that passes its check, or one beyond it; level by level."""
    fits, tolerance = samples.fits, samples.tolerance
    beyond = int(np.log2(refinement))
    passed: dict[Receiver, int] = {}
    pending = receivers
    for level in range(MOST_LEVELS + beyond + 1):
        if not pending:
            return
        samples.evaluate(level, blocks.indices(fits.block, level), pending)
        samples.evaluate(level + 1, blocks.halfway(fits.block, level, _CHECKS), pending)
        halfway = common.halfway(samples, level)
        made: dict[Receiver, TransferBlock] = {}
        waiting = []
        for receiver in pending:
            distance = 0.0 if receiver == "rail" else max(float(receiver) - samples.track.half_width, 0.0)
            direct = np.array(samples.at(level + 1, halfway.place, receiver))
            found = halfway.references(
                receiver,
                distance,
                samples.at(level, halfway.row, receiver),
                direct,
                tolerance,
                must=receiver in passed or level >= MOST_LEVELS,
            )
            if found is not None:
                passed.setdefault(receiver, level)
            if found is None or level < passed[receiver] + beyond:
                waiting.append(receiver)
                continue
            table = TransferBlock(
                common.table(samples, level),
                transfer=np.array(samples.at(level, blocks.indices(fits.block, level), receiver)),
                receiver="rail" if receiver == "rail" else "ground",
                offset=np.nan if receiver == "rail" else float(receiver),
                distance=distance,
                square_level=level,
                reference_slowness=tuple(found[0].tolist()),
                interpolation_error=found[1],
            )
            nothing = halfway.nothing(receiver, direct)
            finer = square_level(table, samples.track, halfway.place, direct, nothing, tolerance)
            made[receiver] = replace(table, square_level=finer)
        if made:
            yield made
        pending = waiting


def _rational_form(fits: GroundFits, level: int, ks: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fits of a level as the arrays of a table, terms that a frequency lacks filled with NaN."""
    made = [fits.at(level, int(k)) for k in ks]
    terms = max(each.pole.size for each in made)
    pole = np.full((ks.size, terms), complex(np.nan, np.nan))
    residue = pole.copy()
    for row, fit in enumerate(made):
        pole[row, : fit.pole.size] = fit.pole
        residue[row, : fit.pole.size] = fit.residue
    return {
        "pole": pole,
        "residue": residue,
        "constant": np.array([each.constant for each in made]),
        "fit_error": np.array([each.error for each in made]),
    }


def _compliance_error(fits: GroundFits, track: Track, reach: float, tolerance: float) -> float:
    """Return the largest relative error of C(β, y) against direct quadrature, at both ends of a class."""
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
                real, imag = strip_compliances(
                    np.array([beta]), fit.pole, fit.residue, fit.constant, b, offsets
                )
                size = np.maximum(np.abs(direct), 1e-8 * np.abs(direct[0]))
                worst = max(worst, float((np.abs(real[:, 0] + 1j * imag[:, 0] - direct) / size).max()))
                spent.evaluations += 1
    return worst
