"""Stage: the rail's transfer function in the frame of a moving load, which a run shows."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from railvib.numerics.frequency_blocks import STEPS
from railvib.stages.model_stage import ModelStage
from railvib.stages.receptances import rail_tables
from railvib.stages.stage import COMPLEX, FLOAT, Load, Scope, Stage
from railvib.stages.tables import transfer_function

if TYPE_CHECKING:
    from railvib.forces.moving_transfer import MovingTransfer

_NODES = 200
"""Wavenumbers of a frequency, about."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RailMovingTransfer(ModelStage):
    """Transfer function of the rail for loads at a speed.

    Attributes
    ----------
    speed
        Of the load, m/s.
    blocks
        Indices of the blocks, ascending without a gap.
    """

    speed: float
    blocks: tuple[int, ...]
    name: ClassVar[str] = "moving_transfer"
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "speed_kmh")
    scope: ClassVar[Scope] = "speed"

    @classmethod
    def result_type(cls) -> "type[MovingTransfer]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.forces.moving_transfer import MovingTransfer

        return MovingTransfer

    def needs(self) -> tuple[Stage, ...]:
        """Return the tables of the rail."""
        return rail_tables(self, self.speed, range(self.blocks[0], self.blocks[-1] + 1))

    def compute(self, load: Load) -> "MovingTransfer":
        """Interpolate the rail's tables."""
        from railvib.forces.moving_transfer import moving_transfer

        return moving_transfer(transfer_function(self.needs(), self.track, load), self.speed, self.blocks)

    def nbytes(self) -> int:
        """Estimate the table: frequencies by nodes."""
        return len(self.blocks) * STEPS * 2 * _NODES * (COMPLEX + FLOAT)

    def memory(self) -> int:
        """Estimate what computing it takes."""
        return 4 * self.nbytes()
