"""Stage: levels of the random passage of a case by any approach."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from railvib.numerics import third_octaves
from railvib.parameters.approach import Approach
from railvib.parameters.receiver import Receiver
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.passage.grid import AT_ONCE, passage_lines
from railvib.stages.full_model import FullModelSpectra
from railvib.stages.model_stage import AnyReceiver, Bands, ModelStage, blocks_over
from railvib.stages.moving_roughness import MovingRoughnessSpectra
from railvib.stages.receptances import RailReceptances
from railvib.stages.stage import COMPLEX, FLOAT, Load, Scope, Stage, Work
from railvib.stages.tables import LoadedFunctions, receiver_tables, tables_memory

if TYPE_CHECKING:
    from railvib.passage.passage_levels import PassageLevels, RandomPassage

_HARMONICS_PER_LINE = 2.0
"""Harmonics over lines, and their share that is heard at a line: 1.4 and 0.2 occurred, on the rail 1."""
_SINGLE = 8
"""Bytes of a complex number in single precision."""
_SAMPLES_PER_LINE = 10.0
"""Samples of a history over lines: nine per period of the highest frequency."""


@dataclass(frozen=True, eq=False, kw_only=True)
class PassageLevelsOfCase(ModelStage):
    """Levels of the passages of one case by one approach.

    Attributes
    ----------
    approach
        The approach.
    train, unevenness
        The train, and the rails' unevenness.
    speed
        m/s.
    band
        One-third octaves that the histories hold, exact midband frequencies, Hz, ascending.
    receivers
        The receivers: the rail first, then by offset.
    metrics
        Names of metrics, see `railvib.parameters.metric`.
    quantiles
        Over realisations of the unevenness.
    passages
        Number of sampled passages; 0 for closed forms.
    seed
        Seed of the ensemble.
    """

    approach: Approach
    train: Train
    unevenness: Unevenness
    speed: float
    band: Bands
    receivers: tuple[AnyReceiver, ...]
    metrics: tuple[str, ...]
    quantiles: tuple[float, ...]
    passages: int
    seed: int
    name: ClassVar[str] = "passage_levels"
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "train", "unevenness", "speed_kmh")
    scope: ClassVar[Scope] = "case"

    @classmethod
    def result_type(cls) -> "type[PassageLevels]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.passage.passage_levels import PassageLevels

        return PassageLevels

    @cached_property
    def _spectra(self) -> FullModelSpectra | MovingRoughnessSpectra:
        """The stage of the case's spectra, which rests on the same tables; it is not needed itself."""
        case: dict[str, Any] = {
            "approach": self.approach,
            "train": self.train,
            "unevenness": self.unevenness,
            "speed": self.speed,
            "band": self.band,
            "receivers": self.receivers,
            "averaging": ("line",),
            **self.model,
        }
        if self.approach == "full":
            return FullModelSpectra(**case)
        return MovingRoughnessSpectra(**case)

    @property
    def _highest_excitation(self) -> float:
        if isinstance(self._spectra, FullModelSpectra):
            return self._spectra.highest_excitation
        return float(third_octaves.edges(self.band)[1][-1]) * 1.1

    @property
    def _rail(self) -> RailReceptances:
        return self._spectra.rail

    def _tables(self, receiver: Receiver) -> tuple[Stage, ...]:
        return receiver_tables(self, receiver, blocks_over(self.band))

    def needs(self) -> list[Stage]:
        """Return the rail's receptances, and the receivers' tables."""
        return [self._rail, *(table for receiver in self.receivers for table in self._tables(receiver))]

    def compute(self, load: Load) -> "PassageLevels":
        """Compute the levels."""
        from railvib.passage.passage_levels import Request, passage_levels

        request = Request(self.metrics, self.quantiles, self.passages, self.seed)
        return passage_levels(self.random_passage(load), self.functions(load), request)

    def random_passage(self, load: Load) -> "RandomPassage":
        """Return the random passage that the levels are those of."""
        from railvib.passage.passage_levels import RandomPassage

        passage, highest = self._spectra.passage, self._highest_excitation
        return RandomPassage(self.approach, passage, self.ground, load(self._rail), highest)

    def functions(self, load: Load) -> LoadedFunctions:
        """Return the receivers' transfer functions, which are loaded when they are asked for."""
        tables = {receiver: self._tables(receiver) for receiver in self.receivers}
        return LoadedFunctions(tables, self.track, load)

    @property
    def _lines(self) -> float:
        return float(passage_lines(self.band, self.train.length, self.speed).size)

    @property
    def _sets(self) -> int:
        return self.train.axle_count if self.approach == "moving-roughness-uncorrelated" else 1

    def nbytes(self) -> int:
        """Estimate the rows: numbers, and texts of some forty letters."""
        rows = len(self.receivers) * (len(self.metrics) + len(self.band)) * (2 + len(self.quantiles))
        return rows * 2 * (FLOAT + 40)

    def memory(self) -> int:
        """Estimate what a receiver's tables, the amplitudes and the histories take."""
        amplitudes = self._lines**2 * _HARMONICS_PER_LINE * self._sets * _SINGLE
        histories = 3 * AT_ONCE * self._lines * _SAMPLES_PER_LINE * _SINGLE
        excitation = _HARMONICS_PER_LINE * self._lines * self.train.axle_count * self._sets * COMPLEX
        tables = tables_memory(self, self.receivers, self.band)
        return int(tables + amplitudes + histories + 2 * excitation)

    def memory_grows_with(self) -> str:
        """Return the train: its length makes the lines."""
        return "train"

    def work(self) -> Work:
        """Return the amounts of amplitudes, of sampled lines and of histories."""
        receivers, lines = float(len(self.receivers)), self._lines
        batches = math.ceil(self.passages / AT_ONCE)
        values = receivers * lines**2 * self._sets
        histories = (
            receivers * lines * max(self.passages, AT_ONCE) * (len(self.metrics) + len(self.band) / 4.0)
        )
        amounts = {"units": 1.0, "values": values, "sampled": values * batches, "histories": histories}
        return Work(self.name, amounts)
