"""Stage: the spectra of a case by the full model."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.receiver import Receiver
from railvib.psd.lines import LINES_AT_ONCE
from railvib.stages.case_spectra import CaseSpectra, axle_layout
from railvib.stages.model_stage import blocks_over
from railvib.stages.moving_transfer import RailMovingTransfer
from railvib.stages.receptances import RailReceptances
from railvib.stages.stage import COMPLEX, Load, Stage, Work
from railvib.stages.tables import LoadedFunctions, receiver_tables, tables_memory
from railvib.stages.transfer_table import likely_size
from railvib.transfer.highest_frequencies import highest_excitation
from railvib.transfer.nodes import largest_wavenumber

if TYPE_CHECKING:
    from railvib.psd.spectra import Spectra

_PANELS_PER_RAD_M = 3.0
"""Of the excitation: 1 to 3 occurred, fewest on damped soil."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FullModelSpectra(CaseSpectra):
    """Spectra by the full model: moving receptances, and the receivers' transfer functions."""

    approach: Literal["full"]
    SORT: ClassVar[str] = "full"

    @property
    def highest_excitation(self) -> float:
        """Highest frequency of excitation that counts, Hz."""
        largest = largest_wavenumber(self.track, self.refinement)
        highest_line = float(self.lines.frequency[-1])
        return highest_excitation(highest_line, largest, self.speed, self.refinement)

    @property
    def _excited_blocks(self) -> tuple[int, ...]:
        return tuple(blocks.up_to(self.highest_excitation))

    @property
    def rail(self) -> RailReceptances:
        """The stage of the rail's receptances for loads at the train's speed."""
        return RailReceptances(
            speed=self.speed,
            distances=axle_layout(self.train).distances,
            blocks=self._excited_blocks,
            **self.model,
        )

    def needs(self) -> list[Stage]:
        """Return receptances, the response to the axle loads, and the receivers' tables.

        The transfer function behind the receptances is among them, as a run shows it.
        """
        moving = RailMovingTransfer(speed=self.speed, blocks=self._excited_blocks, **self.model)
        tables = [table for receiver in self.receivers for table in self._tables(receiver)]
        return [self.rail, self.quasi_static, moving, *tables]

    def _tables(self, receiver: Receiver) -> tuple[Stage, ...]:
        return receiver_tables(self, receiver, blocks_over(self.band))

    def compute(self, load: Load) -> "Spectra":
        """Predict the spectra."""
        from railvib.psd.full_model_spectra import full_model_spectra

        functions = LoadedFunctions(
            {receiver: self._tables(receiver) for receiver in self.receivers}, self.track, load
        )
        return full_model_spectra(
            self.passage,
            load(self.rail),
            self.quasi_static_psd(load),
            functions,
            self.highest_excitation,
            self.tolerance,
        )

    @property
    def _matrices_memory(self) -> int:
        return 6 * LINES_AT_ONCE * self.train.axle_count**2 * COMPLEX

    @property
    def _excitations(self) -> float:
        """Number of wavenumbers at which forces are needed: some panels of nodes per rad/m."""
        largest = 2.0 * math.pi * self.highest_excitation / self.speed
        return float(math.ceil(_PANELS_PER_RAD_M * largest) * ORDER)

    @property
    def _force_sets(self) -> int:
        """Number of sets of forces: that of the rails, and one of each wheelset that is out of round."""
        return 1 + sum(spectrum is not None for spectrum in self.train.wheel_spectra)

    def memory(self) -> int:
        """Estimate what the tables of receivers in memory at once and the forces of axles take."""
        forces = int(2.0 * self._excitations * (self._force_sets - 1) * self.train.axle_count * COMPLEX)
        return tables_memory(self, self.receivers, self.band) + self._matrices_memory + forces

    def memory_grows_with(self) -> str | None:
        """Return the train where the matrices of its axles take most."""
        return "train" if self._matrices_memory > 0.5 * self.memory() else None

    def work(self) -> Work:
        """Return the amounts of forces and of the sum over wavenumbers."""
        axles, lines = self.train.axle_count, float(self.lines.frequency.size)
        sets, excitations = float(self._force_sets), self._excitations
        block = max(blocks_over(self.band))
        nodes = sum(likely_size(self.ground, block, receiver)[1] for receiver in self.receivers)
        amounts = {
            "units": 1.0,
            "pairs": excitations * axles**2,
            "matrices": excitations * axles**3,
            "turned": sets * lines * excitations * axles,
            "values": min(sets, 2.0) * lines * nodes,
        }
        return Work(self.SORT, amounts, {"passage": ("turned", "values")})
