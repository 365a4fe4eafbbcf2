"""What all stages on ground and track have in common: the model that their transfer functions follow from."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import third_octaves
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.stages.stage import Scope, Stage

AnyReceiver = Annotated[Receiver, BeforeValidator(Receiver.of)]
Bands = tuple[float, ...]
"""Exact midband frequencies of one-third octaves, Hz, ascending."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelStage(Stage):
    """A stage that rests on transfer functions of a track on a ground.

    Attributes
    ----------
    ground, track
        The ground, and the track on it.
    tolerance
        Relative error allowed in the transfer functions.
    cross_section
        Cross-section of the track for the FE/BE model; None for the semi-analytical model.
    refinement
        For studies of convergence, a power of two: 2 halves all steps and doubles all ranges.
    """

    ground: Ground
    track: Track
    tolerance: float
    cross_section: CrossSection | None = None
    refinement: int = 1
    scope: ClassVar[Scope] = "ground"

    @property
    def model(self) -> dict[str, Any]:
        """The fields that it shares with the stages it needs."""
        return {
            "ground": self.ground,
            "track": self.track,
            "tolerance": self.tolerance,
            "cross_section": self.cross_section,
            "refinement": self.refinement,
        }


@lru_cache(256)
def blocks_over(bands: Bands) -> range:
    """Return the blocks that cover one-third octaves; lines just beyond the last edge lie in its halo."""
    lower, upper = third_octaves.edges(bands)
    return blocks.between(float(lower[0]), float(upper[-1]))
