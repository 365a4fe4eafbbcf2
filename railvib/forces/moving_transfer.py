"""The rail's transfer function as a moving load sees it: H̃_R(β, ω − βv), what receptances integrate.

It depends on the speed and on no train, so that all trains at a speed share it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.transfer.nodes import Nodes
from railvib.transfer.transfer_function import TransferFunction

_PANELS = 3
"""Of the table's, to each of those here where waves travel."""


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


def moving_transfer(rail: TransferFunction, speed: float, which: Iterable[int]) -> MovingTransfer:
    """Tabulate the rail's transfer function for a moving load, nearly on the standing load's nodes.

    Of the panels where waves travel three are made one: the table's resolve the ground at some distance too.

    Parameters
    ----------
    rail
        The rail's tabulated transfer function, up to `receptance.highest_tabulated_frequency` of the highest
        block's upper edge.
    speed
        m/s.
    which
        Indices of the blocks, ascending, see `railvib.numerics.frequency_blocks`.
    """
    made = [_block(rail, speed, block) for block in which]
    frequency, beta, value = zip(*made, strict=True)
    return MovingTransfer(np.concatenate(frequency), _joined(beta), _joined(value), speed)


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Return blocks (frequency, node) as one, with NaN where one has fewer nodes."""
    nodes = max(each.shape[1] for each in parts)
    filled = [np.pad(each, ((0, 0), (0, nodes - each.shape[1])), constant_values=np.nan) for each in parts]
    return np.concatenate(filled)


def _block(rail: TransferFunction, speed: float, block: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the frequencies of a block below its upper edge, wavenumbers and values."""
    frequency = blocks.frequency(0, blocks.indices(block, 0)[blocks.HALO : -blocks.HALO - 1])
    nodes = rail.blocks[min(max(block, min(rail.blocks)), max(rail.blocks))].nodes
    waves = nodes.edge[nodes.edge <= 1.0]
    edge = np.concatenate([[0.0], waves[-1:0:-_PANELS][::-1], nodes.edge[nodes.edge > 1.0]])
    half = Nodes(nodes.top_slowness, nodes.largest, edge).wavenumber(frequency)
    beta = np.concatenate([-half[:, ::-1], half], axis=1)
    seen = 2.0 * np.pi * frequency[:, None] - beta * speed
    inside = (np.abs(seen) <= 2.0 * np.pi * rail.highest) & (np.abs(beta) <= rail.reach)
    moving = np.full(beta.shape, complex(np.nan, np.nan))
    moving[inside] = rail.response(beta[inside], seen[inside])
    return frequency, beta, moving
