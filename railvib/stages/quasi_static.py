"""Stage: the response to the axle loads that move past, which all approaches of a case share."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import third_octaves
from railvib.parameters.receiver import Receiver
from railvib.psd.lines import Lines
from railvib.stages.model_stage import AnyReceiver, Bands, ModelStage
from railvib.stages.stage import FLOAT, Load, Scope, Stage
from railvib.stages.tables import LoadedFunctions, receiver_tables, tables_memory
from railvib.transfer.highest_frequencies import highest_quasi_static_frequency

if TYPE_CHECKING:
    from railvib.psd.quasi_static import QuasiStatic


@dataclass(frozen=True, eq=False, kw_only=True)
class QuasiStaticResponse(ModelStage):
    """Spectra of displacement from moving axle loads.

    Attributes
    ----------
    receivers
        The receivers.
    band
        One-third octaves that the narrow-band lines cover, exact midband frequencies, Hz.
    intervals
        How many parts the lines divide each band into.
    speed
        Of the train, m/s.
    train_length
        Length of the train, m.
    axle_position
        Positions of the axles, ascending from 0 at the last one, m.
    axle_load
        Their loads, N.
    """

    receivers: tuple[AnyReceiver, ...]
    band: Bands
    intervals: tuple[int, ...]
    speed: float
    train_length: float
    axle_position: tuple[float, ...]
    axle_load: tuple[float, ...]
    name: ClassVar[str] = "quasi_static"
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "train", "speed_kmh")
    scope: ClassVar[Scope] = "speed"

    def _frequency(self) -> np.ndarray:
        return Lines(self.band, self.intervals).frequency

    @classmethod
    def result_type(cls) -> "type[QuasiStatic]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.psd.quasi_static import QuasiStatic

        return QuasiStatic

    def _tables(self, receiver: Receiver) -> tuple[Stage, ...]:
        """Return a receiver's tables as far up as its response needs them."""
        lower, upper = third_octaves.edges(self.band)
        highest = highest_quasi_static_frequency(self.ground, self.track, receiver, self.speed)
        # One block at least: without any, a transfer function cannot return zero.
        top = min(upper[-1], max(highest, upper[0]))
        return receiver_tables(self, receiver, blocks.between(float(lower[0]), float(top)))

    def needs(self) -> list[Stage]:
        """Return the tables of all receivers."""
        return [table for receiver in self.receivers for table in self._tables(receiver)]

    def compute(self, load: Load) -> "QuasiStatic":
        """Compute the spectra on the narrow-band lines."""
        from railvib.psd.quasi_static import QuasiStatic, quasi_static_spectra

        frequency = self._frequency()
        spectra = quasi_static_spectra(
            self.ground,
            self.track,
            LoadedFunctions(
                {receiver: self._tables(receiver) for receiver in self.receivers}, self.track, load
            ),
            np.asarray(self.axle_position),
            np.asarray(self.axle_load),
            self.train_length,
            self.speed,
            frequency,
        )
        return QuasiStatic(frequency, np.array([spectra[receiver] for receiver in self.receivers]))

    def nbytes(self) -> int:
        """Estimate the spectra."""
        return self._frequency().size * (1 + len(self.receivers)) * FLOAT

    def memory(self) -> int:
        """Estimate what the tables take that are in memory at once."""
        return tables_memory(self, self.receivers, self.band)
