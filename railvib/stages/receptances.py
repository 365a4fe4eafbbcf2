"""Stage: the rail's receptances at the axle distances of a train, standing or moving at a speed."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.receiver import RAIL
from railvib.stages.model_stage import ModelStage
from railvib.stages.stage import COMPLEX, Load, Scope, Stage, Work
from railvib.stages.tables import receiver_tables, transfer_function
from railvib.transfer.highest_frequencies import highest_tabulated_frequency

if TYPE_CHECKING:
    from railvib.forces.receptance import Receptances


@dataclass(frozen=True, eq=False, kw_only=True)
class RailReceptances(ModelStage):
    """Receptances of the rail.

    Attributes
    ----------
    speed
        Of the load, m/s; 0 for a standing one.
    distances
        Signed distances ahead of the load, m, ascending.
    blocks
        Indices of the blocks, ascending without a gap.
    """

    speed: float
    distances: tuple[float, ...]
    blocks: tuple[int, ...]
    name: ClassVar[str] = "receptance"
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "train", "speed_kmh")

    @classmethod
    def result_type(cls) -> "type[Receptances]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.forces.receptance import Receptances

        return Receptances

    @property
    def scope(self) -> Scope:  # type: ignore[override]
        """Ground and track; of moving loads the speed as well."""
        return "speed" if self.speed else "ground"

    def needs(self) -> tuple[Stage, ...]:
        """Return the tables of the rail as far up as the receptances reach."""
        return rail_tables(self, self.speed, self.block_range)

    @property
    def block_range(self) -> range:
        """The blocks as a range."""
        return range(self.blocks[0], self.blocks[-1] + 1)

    def compute(self, load: Load) -> "Receptances":
        """Tabulate the receptances."""
        from railvib.forces.receptance import tabulate_receptances

        return tabulate_receptances(
            transfer_function(self.needs(), self.track, load),
            self.track,
            self.speed,
            self.distances,
            self.block_range,
            self.tolerance,
            self.refinement,
        )

    def nbytes(self) -> int:
        """Estimate the table: frequencies by distances."""
        rows = sum(blocks.indices(block, 1).size for block in self.blocks)
        return int(rows * len(self.distances) * COMPLEX)

    def memory(self) -> int:
        """Estimate what tabulating takes."""
        return 8 * self.nbytes()

    def work(self) -> Work:
        """Return blocks, and blocks times distances."""
        number = float(len(self.blocks))
        sort = "moving receptance" if self.speed else "standing receptance"
        return Work(sort, {"blocks": number, "distances": number * len(self.distances)})


def rail_tables(stage: ModelStage, speed: float, block_range: range) -> tuple[Stage, ...]:
    """Return the tables of the rail that loads at a speed need for receptances over some blocks."""
    if stage.cross_section is not None:  # loads stand, and a table's halo reaches as far as the receptances'
        return receiver_tables(stage, RAIL, block_range)
    highest = highest_tabulated_frequency(stage.track, blocks.reach(block_range[-1]), speed, stage.refinement)
    return receiver_tables(stage, RAIL, blocks.up_to(highest))
