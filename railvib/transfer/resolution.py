"""Nodes that resolve the transfer functions of a class of receivers."""

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.refinement import Panels, divide, halve
from railvib.numerics.wavenumber_panels import nodes_between, unresolved
from railvib.transfer.evaluation import Evaluation
from railvib.transfer.nodes import Nodes, node_range

_MOST_HALVINGS = 12
_RESOLVED = 1e-2
"""Size of a panel's last Legendre coefficients, over tolerance times peak, that resolves it."""


def resolve_nodes(evaluate: Evaluation, tolerance: float, refinement: int) -> Nodes:
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
        bad = unresolved(values) > _RESOLVED * tolerance * peak[..., None]
        return panels.low, np.asarray(bad.any(axis=(0, 1)))

    low = np.concatenate([part for _panels, part in halve(Panels.between(first), check, _MOST_HALVINGS)])
    edge = np.append(np.sort(low), 2.0)
    return Nodes(top, largest, divide(edge, refinement))
