"""The speed of a train as studies have it: what it can be, and what is unusual."""

from typing import Annotated

from pydantic import Field

from railvib.parameters.validation import Number

SLOWEST_KMH, FASTEST_KMH = 1.0, 1000.0
SLOWEST_USUAL_KMH = 10.0

SpeedKmh = Annotated[Number, Field(ge=SLOWEST_KMH, le=FASTEST_KMH)]


def slow(speed_kmh: float) -> str:
    """Return what to say of a speed that was probably given in m/s; nothing of any other."""
    if speed_kmh >= SLOWEST_USUAL_KMH:
        return ""
    return f"{speed_kmh:g} km/h: trains run at {SLOWEST_USUAL_KMH:g} km/h or more; is it in m/s?"
