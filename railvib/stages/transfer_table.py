"""Stage: the transfer function of one receiver over one block of frequencies."""

import math
import warnings
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Self

from railvib.errors import AccuracyWarning
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.refinement import MOST_LEVELS
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import RAIL, Receiver
from railvib.stages.model_stage import AnyReceiver, ModelStage
from railvib.stages.stage import COMPLEX, FLOAT, Load, Work
from railvib.transfer.receiver_classes import VALUES_AT_ONCE

if TYPE_CHECKING:
    from railvib.transfer.table import TransferBlock

_SURVIVING = 8.0
"""Wavelengths times loss factor after which tables grow no more with distance: e^{−8π} is left of a wave."""
_CHECKS = 5
"""Places between the frequencies of each level at which a table is checked."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TransferTable(ModelStage):
    """Table of a receiver's transfer function by the semi-analytical model.

    Attributes
    ----------
    receiver
        The receiver.
    block
        Index of the block, see `railvib.numerics.frequency_blocks`.
    """

    receiver: AnyReceiver
    block: int
    name: ClassVar[str] = "transfer"
    at_once: ClassVar[int | None] = VALUES_AT_ONCE
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "offsets_m")

    @classmethod
    def result_type(cls) -> "type[TransferBlock]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.transfer.table import TransferBlock

        return TransferBlock

    def together(self) -> Hashable:
        """Return the same table of the rail: receivers of a block share the fits of the ground."""
        return replace(self, receiver=RAIL)

    def label(self) -> str | None:
        """Return the receiver's label; the rail is stored alone."""
        return None if self.receiver.on_rail else self.receiver.label

    def compute(self, load: Load) -> "TransferBlock":
        """Tabulate it."""
        return next(results[self] for results in self.compute_together([self], load))

    @classmethod
    def compute_together(cls, stages: Sequence[Self], load: Load) -> Iterator[Mapping[Self, "TransferBlock"]]:
        """Tabulate the receivers of a block class by class."""
        from railvib.transfer.tabulate import transfer_blocks_by_class

        first = stages[0]
        stage_at = {stage.receiver: stage for stage in stages}
        for tables in transfer_blocks_by_class(
            first.ground,
            first.track,
            first.block,
            stage_at,
            first.tolerance,
            first.refinement,
            first.evaluation(),
        ):
            for table in tables.values():
                shortfall = table.shortfall(first.tolerance)
                if shortfall:
                    warnings.warn(shortfall, AccuracyWarning, stacklevel=2)
            yield {stage_at[receiver]: table for receiver, table in tables.items()}

    def evaluation(self) -> Any:
        """Return what evaluates the transfer functions; None for the semi-analytical model."""
        return None

    def nbytes(self) -> int:
        """Estimate the table: frequencies by nodes."""
        rows, nodes = table_size(self.ground, self.block, self.receiver)
        return int(rows * nodes * (COMPLEX + FLOAT))

    def memory(self) -> int:
        """Estimate what tabulating takes."""
        return 4 * self.nbytes()

    def work(self) -> Work:
        """Return fits, shared by the receivers of a task, and values of the receivers' functions."""
        return self.work_together([self])

    @classmethod
    def work_together(cls, stages: Sequence[Self]) -> Work:
        """Return the amounts of work of a block's receivers."""
        ground = stages[0].ground
        sizes = [likely_size(ground, stage.block, stage.receiver) for stage in stages]
        values = sum(rows * nodes for rows, nodes in sizes)
        fits = 1.0 if len(ground.layers) == 1 else max(rows for rows, _ in sizes) + _CHECKS
        amounts = {
            "tasks": 1.0,
            "fits": fits,
            "fits of layers": fits * len(ground.layers),
            "receivers": float(len(stages)),
            "evaluations": 1.0,
            "values": values,
        }
        by_cost = {"fit": ("fits", "fits of layers"), "transfer functions": ("evaluations", "values")}
        return Work(cls.name, amounts, by_cost)


def table_size(ground: Ground, block: int, receiver: Receiver) -> tuple[int, float]:
    """Return about how many frequencies and nodes a receiver's table has at most: for memory and disk."""
    waves = _waves_between(ground, block, receiver)
    return _rows(block, waves, 4.0), 400.0 + 10.0 * waves


def likely_size(ground: Ground, block: int, receiver: Receiver) -> tuple[int, float]:
    """Return how many frequencies and nodes a receiver's table is likely to have: for work.

    Compared with the tables of eight receivers to 100 m on both soils of the paper, up to 224 Hz.
    """
    _, surviving = _slowest_and_surviving(ground)
    waves = min(_waves_between(ground, block, receiver), 0.5 * surviving)
    return _rows(block, waves, 8.0), 300.0 + 9.0 * waves


def _rows(block: int, waves: float, waves_followed: float) -> int:
    """Return the frequencies of a table whose coarsest level follows some wavelengths."""
    level = min(max(math.ceil(math.log2(max(waves, 1.0) / waves_followed)), 0), MOST_LEVELS)
    return int(blocks.indices(block, level).size)


def _waves_between(ground: Ground, block: int, receiver: Receiver) -> float:
    """Return how many wavelengths lie between track and receiver at a block's highest frequency, at most.

    No more than leave something of a wave in the layer that damps least.
    """
    slowest, surviving = _slowest_and_surviving(ground)
    return min((receiver.offset or 0.0) * float(blocks.edges(block)[1]) / slowest, surviving)


@lru_cache(256)
def _slowest_and_surviving(ground: Ground) -> tuple[float, float]:
    """Return the speed of a ground's slowest wave, and the wavelengths after which nothing is left of it."""
    return ground.slowest_speed, _SURVIVING / max(min(layer.loss_factor for layer in ground.layers), 1e-3)
