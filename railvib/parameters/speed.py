"""The speed of a train as studies have it: what it can be, and what is unusual."""

from typing import Annotated

from pydantic import Field

from railvib.parameters.validation import Number

SpeedKmh = Annotated[Number, Field(ge=1.0, le=1000.0)]

SLOWEST_USUAL_KMH = 10.0


def slow(speed_kmh: float) -> str:
    """Return what to say of a speed that was probably given in m/s; nothing of any other."""
    if speed_kmh >= SLOWEST_USUAL_KMH:
        return ""
    return f"{speed_kmh:g} km/h: trains run at {SLOWEST_USUAL_KMH:g} km/h or more; is it in m/s?"
