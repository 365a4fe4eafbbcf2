"""The tables of a stage's receivers: which there are, and their results as transfer functions."""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.stages.fe_be_table import FeBeTable
from railvib.stages.model_stage import Bands, ModelStage, blocks_over
from railvib.stages.stage import Load, Stage
from railvib.stages.transfer_table import TransferTable
from railvib.transfer.receiver_classes import RECEIVERS_AT_ONCE

if TYPE_CHECKING:
    from railvib.transfer.transfer_function import TransferFunction

REMEMBERED = 4096
"""Sequences of tables that planning keeps, as many cases share them."""


def receiver_tables(stage: ModelStage, receiver: Receiver, block_range: range) -> tuple[TransferTable, ...]:
    """Return the stages of a receiver's transfer function over some blocks, for the model of a stage."""
    return _tables(tuple(stage.model.items()), receiver, block_range)


@lru_cache(REMEMBERED)
def _tables(
    model: tuple[tuple[str, Any], ...], receiver: Receiver, block_range: range
) -> tuple[TransferTable, ...]:
    fields = dict(model)
    table = TransferTable if fields["cross_section"] is None else FeBeTable
    # The highest block first: it takes longest.
    return tuple(table(block=block, receiver=receiver, **fields) for block in reversed(block_range))


def transfer_function(tables: Sequence[Stage], track: Track, load: Load) -> "TransferFunction":
    """Return a transfer function from the stages of its tables."""
    from railvib.transfer.transfer_function import TransferFunction

    return TransferFunction([load(table) for table in tables], track)


class LoadedFunctions(Mapping[Receiver, "TransferFunction"]):
    """Transfer functions by receiver, loaded each time that one is asked for.

    Tables of a hundred receivers take more memory than a worker has: whoever goes through them one by one
    has one in memory at a time, beside what the worker keeps.
    """

    def __init__(self, tables: Mapping[Receiver, Sequence[Stage]], track: Track, load: Load) -> None:
        self._tables = tables
        self._track = track
        self._load = load

    def __getitem__(self, receiver: Receiver) -> "TransferFunction":
        return transfer_function(self._tables[receiver], self._track, self._load)

    def __iter__(self) -> Iterator[Receiver]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)


def tables_memory(stage: ModelStage, receivers: Sequence[Receiver], bands: Bands) -> int:
    """Estimate what the tables of the receivers in memory at once take, and what is derived from them."""
    sizes = sorted(
        sum(table.nbytes() for table in receiver_tables(stage, receiver, blocks_over(bands)))
        for receiver in receivers
    )
    return 2 * sum(sizes[-RECEIVERS_AT_ONCE:])
