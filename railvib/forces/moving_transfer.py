"""The rail's transfer function as a moving load sees it: H̃_R(β, ω − βv), the integrand of receptances.

It depends on the speed but not on the train, so all trains at a speed share it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.transfer.nodes import Nodes
from railvib.transfer.transfer_function import TransferFunction

_PANELS_MERGED = 3
"""Number of the table's panels that are merged into one where waves travel."""


@dataclass(frozen=True)
class MovingTransfer:
    """H̃_R(β, ω − βv) at one speed over blocks of the load's frequencies, those of level 0."""

    frequency: np.ndarray = field(
        metadata={"dims": ("frequency",), "unit": "Hz", "description": "frequency of the load"}
    )
    wavenumber: np.ndarray = field(
        metadata={
            "dims": ("frequency", "node"),
            "unit": "rad/m",
            "description": "wavenumber along the track, of either sign; NaN where a block has fewer nodes",
        }
    )
    rail_moving: np.ndarray = field(
        metadata={
            "dims": ("frequency", "node"),
            "unit": "m2/N",
            "description": "rail at the frequency that the track sees; NaN where that is not tabulated",
        }
    )
    speed: float
    """Speed of the load, m/s."""


def moving_transfer(rail: TransferFunction, speed: float, block_range: Iterable[int]) -> MovingTransfer:
    """Tabulate the rail's transfer function for a moving load, on coarser panels than its tables'.

    Where waves travel, three panels are merged: the tables' panels resolve the ground at some distance too.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `highest_tabulated_frequency` (in
        `railvib.transfer.highest_frequencies`) of the highest block's upper edge.
    speed
        m/s.
    block_range
        Indices of the blocks, ascending, see `railvib.numerics.frequency_blocks`.
    """
    frequency, beta, value = zip(*(_block(rail, speed, block) for block in block_range), strict=True)
    return MovingTransfer(np.concatenate(frequency), _concatenate(beta), _concatenate(value), speed)


def _concatenate(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Return blocks (frequency, node) as one, with NaN where a block has fewer nodes."""
    nodes = max(part.shape[1] for part in parts)
    return np.concatenate(
        [np.pad(part, ((0, 0), (0, nodes - part.shape[1])), constant_values=np.nan) for part in parts]
    )


def _block(rail: TransferFunction, speed: float, block: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the frequencies of a block below its upper edge, wavenumbers and values."""
    frequency = blocks.frequency(0, blocks.indices(block, 0)[blocks.HALO : -blocks.HALO - 1])
    nodes = rail.blocks[min(max(block, min(rail.blocks)), max(rail.blocks))].nodes
    waves = nodes.edge[nodes.edge <= 1.0]
    edge = np.concatenate([[0.0], waves[-1:0:-_PANELS_MERGED][::-1], nodes.edge[nodes.edge > 1.0]])
    half = Nodes(nodes.top_slowness, nodes.largest, edge).wavenumber(frequency)
    beta = np.concatenate([-half[:, ::-1], half], axis=1)
    seen = 2.0 * np.pi * frequency[:, None] - beta * speed
    inside = (np.abs(seen) <= 2.0 * np.pi * rail.highest) & (np.abs(beta) <= rail.reach)
    moving = np.full(beta.shape, complex(np.nan, np.nan))
    moving[inside] = rail.response(beta[inside], seen[inside])
    return frequency, beta, moving
