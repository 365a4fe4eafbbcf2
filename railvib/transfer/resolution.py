"""Nodes that resolve the transfer functions of a class of receivers."""

import numpy as np

from railvib.numerics import frequency_blocks as blocks
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
    edge = np.unique(
        [0.0, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, *(1.0 / (speed * top) for speed in ground.wave_speeds())]
    )
    pending = np.stack([edge[:-1], edge[1:]], axis=1)
    finished: list[np.ndarray] = []
    peak = np.zeros((ks.size, 1 + evaluate.offsets.size))
    for _ in range(_MOST_HALVINGS):
        # Each pending panel alone, between its own two edges.
        ends = Nodes(top, largest, pending.ravel()).panel_edges(frequency).reshape(ks.size, -1, 2)
        betas = nodes_between(ends).reshape(ks.size, -1)
        values = np.array([evaluate(0, int(k), beta) for k, beta in zip(ks, betas, strict=True)])
        peak = np.maximum(peak, np.abs(values).max(axis=2))
        bad = (unresolved(values) > _RESOLVED * tolerance * peak[..., None]).any(axis=(0, 1))
        finished.append(pending[~bad])
        middle = pending[bad].mean(axis=1)
        pending = np.concatenate(
            [np.stack([pending[bad, 0], middle], axis=1), np.stack([middle, pending[bad, 1]], axis=1)]
        )
        if not bad.any():
            break
    edge = np.append(np.sort(np.concatenate([*finished, pending])[:, 0]), 2.0)
    fine = np.interp(np.arange(refinement * (edge.size - 1) + 1) / refinement, np.arange(edge.size), edge)
    return Nodes(top, largest, fine)
