"""The rail's transfer function as a moving load sees it: H̃_R(β, ω − βv), what receptances integrate.

It depends on the speed and on no train, so that all trains at a speed share it.
"""

from dataclasses import dataclass, field

import numpy as np

from railvib import blocks
from railvib.transfer import Nodes, TransferFunction

_PANELS = 3
"""Of the table's, to each of those here where waves travel."""


@dataclass(frozen=True)
class MovingTransferBlock:
    """H̃_R(β, ω − βv) over one block of the load's frequencies, those of level 0, at one speed."""

    frequency: np.ndarray = field(
        metadata={"dims": ("frequency",), "unit": "Hz", "description": "frequency of the load"}
    )
    wavenumber: np.ndarray = field(
        metadata={
            "dims": ("frequency", "node"),
            "unit": "rad/m",
            "description": "wavenumber along the track, of either sign",
        }
    )
    rail_moving: np.ndarray = field(
        metadata={
            "dims": ("frequency", "node"),
            "unit": "m2/N",
            "description": "rail at the frequency that the track sees; NaN where that is not tabulated",
        }
    )
    block: int
    """Index of the block, see `railvib.blocks`."""
    speed: float
    """Speed of the load, m/s."""


def moving_transfer_block(rail: TransferFunction, speed: float, block: int) -> MovingTransferBlock:
    """Tabulate the rail's transfer function for a moving load, nearly on the standing load's nodes.

    Of the panels where waves travel three are made one: the table's resolve the ground at some distance too.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `receptance.highest_tabulated_frequency` of the block's
        upper edge.
    speed
        m/s.
    block
        Index of the block, see `railvib.blocks`.
    """
    frequency = blocks.frequency(0, blocks.indices(block, 0)[blocks.HALO : -blocks.HALO])
    table = rail.blocks[min(max(block, min(rail.blocks)), max(rail.blocks))]
    waves = table.edge[table.edge <= 1.0]
    kept = np.concatenate([[0.0], waves[-1:0:-_PANELS][::-1], table.edge[table.edge > 1.0]])
    half = Nodes(table.top_slowness, table.largest, kept).wavenumber(frequency)
    beta = np.concatenate([-half[:, ::-1], half], axis=1)
    seen = 2.0 * np.pi * frequency[:, None] - beta * speed
    inside = (np.abs(seen) <= 2.0 * np.pi * rail.highest) & (np.abs(beta) <= rail.reach)
    moving = np.full(beta.shape, complex(np.nan, np.nan))
    moving[inside] = rail.response(beta[inside], seen[inside])
    return MovingTransferBlock(frequency, beta, moving, block, speed)
