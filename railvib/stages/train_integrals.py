"""Stage: one receiver's integrals over the length of a train, for moving roughness averaged so (Eq. 26)."""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from railvib import library
from railvib.parameters.receiver import RAIL
from railvib.psd.lines import Lines
from railvib.stages.model_stage import AnyReceiver, Bands, ModelStage, blocks_over
from railvib.stages.stage import COMPLEX, Load, Stage, Work
from railvib.stages.tables import receiver_tables, transfer_function
from railvib.stages.transfer_table import likely_size

if TYPE_CHECKING:
    from railvib.psd.train_average import TrainIntegrals


@dataclass(frozen=True, eq=False, kw_only=True)
class ReceiverTrainIntegrals(ModelStage):
    """Integrals over the train on the narrow-band lines of a case.

    Attributes
    ----------
    receiver
        The receiver.
    band
        One-third octaves that the lines cover, exact midband frequencies, Hz.
    intervals
        How many parts the lines divide each band into.
    axle_position
        Positions of the axles, ascending from 0 at the last one, m.
    """

    receiver: AnyReceiver
    band: Bands
    intervals: tuple[int, ...]
    axle_position: tuple[float, ...]
    name: ClassVar[str] = "train_integrals"
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "train", "offsets_m")

    @classmethod
    def result_type(cls) -> "type[TrainIntegrals]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.psd.train_average import TrainIntegrals

        return TrainIntegrals

    @classmethod
    def compile(cls) -> None:
        """Compile the kernel of averages over the train."""
        _compile()

    def needs(self) -> tuple[Stage, ...]:
        """Return the receiver's tables over the bands."""
        return receiver_tables(self, self.receiver, blocks_over(self.band))

    def _frequency(self) -> np.ndarray:
        return Lines(self.band, self.intervals).frequency

    def compute(self, load: Load) -> "TrainIntegrals":
        """Integrate."""
        from railvib.psd.train_average import train_integrals

        function = transfer_function(self.needs(), self.track, load)
        return train_integrals(function, np.asarray(self.axle_position), self._frequency())

    def nbytes(self) -> int:
        """Estimate the integrals: lines by pairs of axles."""
        return self._frequency().size * len(self.axle_position) ** 2 * COMPLEX

    def memory(self) -> int:
        """Estimate what integrating takes."""
        return 2 * self.nbytes()

    def work(self) -> Work:
        """Return values of the transfer function, and values times pairs of axles."""
        nodes = likely_size(self.ground, max(blocks_over(self.band)), self.receiver)[1]
        values = float(self._frequency().size) * nodes
        amounts = {"units": 1.0, "values": values, "values of axles": values * len(self.axle_position) ** 2}
        return Work(self.name, amounts)


@cache
def _compile() -> None:
    from railvib.psd.train_average import train_integrals
    from railvib.transfer.tabulate import transfer_blocks
    from railvib.transfer.transfer_function import TransferFunction

    ground, track = library.load("soil", "horstwalde"), library.load("track", "ballasted-paper")
    tables = transfer_blocks(ground, track, 0, [RAIL], 1e-2)
    train_integrals(TransferFunction(tables.values(), track), np.array([0.0, 2.0]), np.array([2.0]))
