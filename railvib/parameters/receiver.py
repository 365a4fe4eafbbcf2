"""Where vibration is received: on the rail, or on the ground beside the track."""

from dataclasses import dataclass
from typing import Any, Literal

from railvib.parameters.track import Track

Key = str | float
"""How a receiver stands in identities and stored records: ``"rail"``, or the offset in m."""

FARTHEST = 2000.0
"""Largest offset, m: beyond it nothing of a train is left, and tables grow with the distance."""


@dataclass(frozen=True, slots=True)
class Receiver:
    """A receiver on the rail, or on the ground at an offset from the track's centre line.

    Attributes
    ----------
    offset
        Distance from the centre line, m; None on the rail.
    """

    offset: float | None = None

    @classmethod
    def of(cls, value: Any) -> "Receiver":
        """Return the receiver that a key stands for; a receiver stands for itself."""
        if isinstance(value, Receiver):
            return value
        return cls() if value == "rail" else cls(float(value))

    @property
    def on_rail(self) -> bool:
        """Whether it is on the rail."""
        return self.offset is None

    @property
    def key(self) -> Key:
        """``"rail"``, or the offset in m."""
        return "rail" if self.offset is None else self.offset

    @property
    def name(self) -> Literal["rail", "ground"]:
        """``"rail"`` or ``"ground"``."""
        return "rail" if self.offset is None else "ground"

    @property
    def offset_m(self) -> float:
        """Offset as a number, m; NaN on the rail."""
        return float("nan") if self.offset is None else self.offset

    @property
    def rank(self) -> float:
        """What receivers are sorted by: the rail first, then by offset."""
        return -1.0 if self.offset is None else self.offset

    def follows(self, track: Track) -> bool:
        """Return whether its displacement is that of the rail, or of the ground that the track follows."""
        return self.on_rail or (self.offset == 0.0 and not track.follows_mean)

    @property
    def label(self) -> str:
        """Shortest text that tells it from others: ``"rail"``, ``"8"``, ``"12.5"``."""
        return "rail" if self.offset is None else repr(float(self.offset)).removesuffix(".0")

    @property
    def title(self) -> str:
        """Text for people: ``"rail"``, ``"ground 8 m"``."""
        return "rail" if self.offset is None else f"ground {self.offset:g} m"

    def distance(self, half_width: float) -> float:
        """Return how far waves travel from the edge of a track, m; 0 on the rail and under the track.

        Parameters
        ----------
        half_width
            Half the width over which the track presses on the ground, m.
        """
        return 0.0 if self.offset is None else max(self.offset - half_width, 0.0)


RAIL = Receiver()
CENTRE = Receiver(0.0)
"""On the ground at the centre line."""
