"""Stage: the spectra of a case by moving roughness, in any of its forms."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from railvib.parameters.receiver import Receiver
from railvib.psd.lines import LINES_AT_ONCE
from railvib.stages.case_spectra import CaseSpectra, axle_layout
from railvib.stages.line_integrals import ReceiverLineIntegrals
from railvib.stages.model_stage import blocks_over
from railvib.stages.receptances import RailReceptances
from railvib.stages.stage import COMPLEX, Load, Stage, Work
from railvib.stages.train_integrals import ReceiverTrainIntegrals

if TYPE_CHECKING:
    from railvib.psd.spectra import Spectra


@dataclass(frozen=True, eq=False, kw_only=True)
class MovingRoughnessSpectra(CaseSpectra):
    """Spectra by moving roughness: standing receptances, and integrals along the line or the train."""

    approach: Literal[
        "moving-roughness", "moving-roughness-by-axle", "moving-roughness-uncorrelated", "fe-be"
    ]
    SORT: ClassVar[str] = "moving roughness"

    @property
    def rail(self) -> RailReceptances:
        """The stage of the rail's standing receptances."""
        return RailReceptances(
            speed=0.0,
            distances=axle_layout(self.train).distances,
            blocks=tuple(blocks_over(self.band)),
            **self.model,
        )

    def line_integrals(self, receiver: Receiver) -> ReceiverLineIntegrals:
        """Return the stage of a receiver's line integrals."""
        return ReceiverLineIntegrals(
            receiver=receiver,
            distances=tuple(d for d in axle_layout(self.train).distances if d >= 0.0),
            blocks=tuple(blocks_over(self.band)),
            **self.model,
        )

    def train_integrals(self, receiver: Receiver) -> ReceiverTrainIntegrals:
        """Return the stage of a receiver's integrals over the train."""
        return ReceiverTrainIntegrals(
            receiver=receiver,
            band=self.band,
            intervals=self.passage.lines.intervals,
            axle_position=axle_layout(self.train).position,
            **self.model,
        )

    @property
    def _averages_over_train(self) -> tuple[Receiver, ...]:
        return self.receivers if "train" in self.averaging else ()

    def needs(self) -> list[Stage]:
        """Return receptances, the response to the axle loads, and the receivers' integrals."""
        return [
            self.rail,
            self.quasi_static,
            *(self.line_integrals(receiver) for receiver in self.receivers),
            *(self.train_integrals(receiver) for receiver in self._averages_over_train),
        ]

    def compute(self, load: Load) -> "Spectra":
        """Predict the spectra."""
        from railvib.psd.moving_roughness_spectra import moving_roughness_spectra

        return moving_roughness_spectra(
            self.approach,
            self.passage,
            load(self.rail),
            self.quasi_static_psd(load),
            {receiver: load(self.line_integrals(receiver)) for receiver in self.receivers},
            {receiver: load(self.train_integrals(receiver)) for receiver in self._averages_over_train},
        )

    def memory(self) -> int:
        """Estimate what the matrices of axles take at the lines that are computed together."""
        return 6 * LINES_AT_ONCE * self.train.axle_count**2 * COMPLEX

    def memory_grows_with(self) -> str:
        """Return the train: its axles make the matrices."""
        return "train"

    def work(self) -> Work:
        """Return pairs of axles, their matrices, and pairs of axles at receivers."""
        axles, lines = self.train.axle_count, float(self.lines.frequency.size)
        if self.train.has_rough_wheels:  # matrices once more, for each wheelset alone
            lines *= 2.0
        pairs = lines * axles**2
        amounts = {
            "units": 1.0,
            "pairs": pairs,
            "matrices": lines * axles**3,
            "pairs of receivers": pairs * len(self.receivers) * len(self.averaging),
        }
        return Work(self.SORT, amounts, {"line average": ("pairs of receivers",)})
