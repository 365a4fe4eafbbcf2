"""What the spectra of a case by any approach have in common."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from railvib.parameters.approach import Approach
from railvib.parameters.receiver import Receiver
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.psd.lines import Lines, lines
from railvib.stages.model_stage import AnyReceiver, Bands, ModelStage
from railvib.stages.quasi_static import QuasiStaticResponse
from railvib.stages.stage import FLOAT, Load, Scope

if TYPE_CHECKING:
    from railvib.psd.spectra import Passage, Spectra


@dataclass(frozen=True, eq=False, kw_only=True)
class CaseSpectra(ModelStage):
    """Spectra of forces and velocities of one case by one approach.

    Attributes
    ----------
    approach
        The approach.
    train, unevenness
        The train, and the rails' unevenness.
    speed
        m/s.
    band
        One-third octaves, exact midband frequencies, Hz, ascending.
    receivers
        The receivers: the rail first, then by offset.
    averaging
        What moving roughness is averaged over: the line, the train, or both, in alphabetical order.
    """

    approach: Approach
    train: Train
    unevenness: Unevenness
    speed: float
    band: Bands
    receivers: tuple[AnyReceiver, ...]
    averaging: tuple[str, ...]
    name: ClassVar[str] = "spectra"
    grows_with: ClassVar[tuple[str, ...]] = ("soil", "track", "train", "unevenness", "speed_kmh")
    scope: ClassVar[Scope] = "case"

    @classmethod
    def result_type(cls) -> "type[Spectra]":
        """Return the frozen dataclass of arrays that is computed."""
        from railvib.psd.spectra import Spectra

        return Spectra

    @property
    def lines(self) -> Lines:
        """The narrow-band lines."""
        return lines(self.band, self.train, self.speed, self.refinement)

    @property
    def passage(self) -> "Passage":
        """The train over the unevenness."""
        from railvib.psd.spectra import Passage

        return Passage(self.train, self.unevenness, self.speed, self.band, self.refinement)

    @property
    def quasi_static(self) -> QuasiStaticResponse:
        """The stage of the response to the axle loads."""
        axles = axle_layout(self.train)
        return QuasiStaticResponse(
            receivers=self.receivers,
            band=self.band,
            intervals=self.lines.intervals,
            speed=self.speed,
            train_length=self.train.length,
            axle_position=axles.position,
            axle_load=axles.load,
            **self.model,
        )

    def quasi_static_psd(self, load: Load) -> dict[Receiver, np.ndarray]:
        """Return the PSDs of displacement from the axle loads by receiver, m²/Hz, (lines,)."""
        psd = load(self.quasi_static).psd
        return dict(zip(self.receivers, psd, strict=True))

    def nbytes(self) -> int:
        """Estimate the spectra."""
        forces, velocities = (3, 5) if self.train.has_rough_wheels else (1, 3)
        series = forces * self.train.axle_count + velocities * len(self.receivers) * len(self.averaging)
        return series * (self.lines.frequency.size + len(self.band)) * FLOAT


class AxleLayout(NamedTuple):
    """What the stages of a train take from it: positions from the last axle, m; loads, N; distances, m."""

    position: tuple[float, ...]
    load: tuple[float, ...]
    distances: tuple[float, ...]


@lru_cache(256)
def axle_layout(train: Train) -> AxleLayout:
    """Return the axles of a train, ascending in x."""
    position = np.round(train.axle_positions - train.axle_positions[0], 9)
    return AxleLayout(
        tuple(position.tolist()), tuple(train.axle_loads.tolist()), tuple(train.axle_distances.tolist())
    )
