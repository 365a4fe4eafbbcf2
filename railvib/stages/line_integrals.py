"""Stage: one receiver's integrals along the line, which moving roughness averages over."""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Self

from railvib.parameters.receiver import RAIL
from railvib.stages.model_stage import AnyReceiver, ModelStage
from railvib.stages.stage import FLOAT, Load, Stage, Work
from railvib.stages.tables import receiver_tables, transfer_function
from railvib.stages.transfer_table import likely_size, table_size
from railvib.transfer.receiver_classes import RECEIVERS_AT_ONCE, distance_class

if TYPE_CHECKING:
    from railvib.psd.line_integrals import LineIntegrals


@dataclass(frozen=True, eq=False, kw_only=True)
class ReceiverLineIntegrals(ModelStage):
    """Integrals M(d, f) of one receiver over some blocks.

    Attributes
    ----------
    receiver
        The receiver.
    distances
        Distances between axles, m, ascending from 0.
    blocks
        Indices of the blocks, ascending without a gap.
    """

    receiver: AnyReceiver
    distances: tuple[float, ...]
    blocks: tuple[int, ...]
    name: ClassVar[str] = "line_integrals"
    at_once: ClassVar[int | None] = RECEIVERS_AT_ONCE
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "train", "offsets_m")

    @classmethod
    def result_type(cls) -> "type[LineIntegrals]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.psd.line_integrals import LineIntegrals

        return LineIntegrals

    def together(self) -> Hashable:
        """Return the same integrals of the rail: receivers of a class share their nodes."""
        return replace(self, receiver=RAIL)

    def label(self) -> str:
        """Return the receiver's label."""
        return self.receiver.label

    def needs(self) -> tuple[Stage, ...]:
        """Return the receiver's tables."""
        return receiver_tables(self, self.receiver, range(self.blocks[0], self.blocks[-1] + 1))

    def compute(self, load: Load) -> "LineIntegrals":
        """Integrate."""
        return next(results[self] for results in self.compute_together([self], load))

    @classmethod
    def compute_together(cls, stages: Sequence[Self], load: Load) -> Iterator[Mapping[Self, "LineIntegrals"]]:
        """Integrate receivers, those of one class of distances together."""
        from railvib.psd.line_integrals import line_integrals

        first = stages[0]
        classes: dict[float, list[Self]] = {}
        for stage in stages:
            classes.setdefault(distance_class(stage.receiver), []).append(stage)
        for members in classes.values():
            for start in range(0, len(members), RECEIVERS_AT_ONCE):
                batch = {stage.receiver: stage for stage in members[start : start + RECEIVERS_AT_ONCE]}
                functions = {
                    receiver: transfer_function(stage.needs(), stage.track, load)
                    for receiver, stage in batch.items()
                }
                integrals = line_integrals(
                    functions, first.distances, first.blocks, first.tolerance, first.refinement
                )
                yield {batch[receiver]: integral for receiver, integral in integrals.items()}

    def nbytes(self) -> int:
        """Estimate the table: frequencies by distances."""
        sizes = [table_size(self.ground, block, self.receiver) for block in self.blocks]
        return sum(rows for rows, _ in sizes) * len(self.distances) * FLOAT

    def memory(self) -> int:
        """Estimate what integrating takes, with the tables that are read."""
        return 2 * sum(table.nbytes() for table in self.needs()) + 4 * self.nbytes()

    def work(self) -> Work:
        """Return values of the tables, and values times distances."""
        sizes = [likely_size(self.ground, block, self.receiver) for block in self.blocks]
        values = sum(rows * nodes for rows, nodes in sizes)
        amounts = {"units": 1.0, "values": values, "values of axles": values * len(self.distances)}
        return Work(self.name, amounts)
