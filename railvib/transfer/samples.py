"""Direct values of transfer functions on the nodes of a class, each frequency and receiver computed once."""

from collections.abc import Sequence

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.receiver import CENTRE, Receiver
from railvib.parameters.track import Track
from railvib.soil.fits import GroundFits
from railvib.transfer.evaluation import Model
from railvib.transfer.nodes import Nodes


class Samples:
    """Direct values on the nodes of a class.

    Parameters
    ----------
    model
        Evaluates the transfer functions.
    fits, track
        Fits of the ground over a block, and the track.
    nodes
        The nodes of the class.
    tolerance
        Relative error allowed.

    Attributes
    ----------
    failed
        Frequencies without a good fit, Hz.
    """

    def __init__(self, model: Model, fits: GroundFits, track: Track, nodes: Nodes, tolerance: float) -> None:
        self.fits = fits
        self.track = track
        self.nodes = nodes
        self.tolerance = tolerance
        self.failed: set[float] = set()
        self._model = model
        self._known: dict[tuple[int, int], dict[Receiver, np.ndarray]] = {}
        self._compliance: dict[tuple[int, int], np.ndarray] = {}
        self._rows: dict[tuple[int, bytes], list[dict[Receiver, np.ndarray]]] = {}

    def evaluate(self, level: int, ks: np.ndarray, receivers: Sequence[Receiver]) -> None:
        """Compute missing values of receivers, and of the centre line, at frequencies of a level."""
        missing_at: dict[tuple[Receiver, ...], list[int]] = {}
        for k in map(int, ks):
            known = self._known.setdefault(_coarsest(level, k), {})
            missing = tuple(receiver for receiver in receivers if receiver not in known)
            if missing:
                missing_at.setdefault(missing, []).append(k)
        for missing, some_ks in missing_at.items():
            offsets = [receiver.offset for receiver in missing if receiver.offset is not None]
            evaluate = self._model(self.fits, self.track, offsets, self.tolerance)
            rows = [(receiver, evaluate.row(receiver)) for receiver in (CENTRE, *missing)]
            betas = self.nodes.wavenumber(blocks.frequency(level, np.array(some_ks)))
            for k, beta in zip(some_ks, betas, strict=True):
                values = evaluate(level, k, beta)
                known = self._known[_coarsest(level, k)]
                known.update({receiver: values[row] for receiver, row in rows})
                if evaluate.compliance is not None:
                    self._compliance[_coarsest(level, k)] = evaluate.compliance
            self.failed |= evaluate.failed

    def at(self, level: int, ks: np.ndarray, receiver: Receiver) -> list[np.ndarray]:
        """Return the values of a receiver at frequencies of a level, each on the nodes."""
        key = level, ks.tobytes()
        if key not in self._rows:
            self._rows[key] = [self._known[_coarsest(level, k)] for k in map(int, ks)]
        return [known[receiver] for known in self._rows[key]]

    def compliance(self, level: int, ks: np.ndarray) -> list[np.ndarray] | None:
        """Return C(β, 0) at frequencies of a level, each on the nodes; None if the model does not know it."""
        return [self._compliance[_coarsest(level, k)] for k in map(int, ks)] if self._compliance else None


def _coarsest(level: int, k: int) -> tuple[int, int]:
    """Return the lowest level that has a frequency, and its index there."""
    while level > 0 and k % 2 == 0:
        level, k = level - 1, k // 2
    return level, k
