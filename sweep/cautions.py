"""What is implausible in a study: refused before anything runs, or said once."""

import warnings

from railvib.errors import InputError, PlausibilityWarning
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.units import KMH
from railvib.plausibility import check_damping, check_speed
from sweep.study import Resolved


def check_plausibility(resolved: Resolved) -> None:
    """Refuse soils without damping.

    Raises
    ------
    InputError
        Naming the soil and the layer.
    """
    for name, ground in resolved.objects["soil"].items():
        assert isinstance(ground, Ground)
        try:
            check_damping(ground)
        except InputError as error:
            raise InputError(f"soil.{name}.{error}") from None


def cautions(resolved: Resolved) -> list[str]:
    """Return where the fastest train outruns waves in ground and track; this takes compiled kernels."""
    fastest = max(resolved.study.sweep.speed_kmh) / KMH
    messages = []
    for name, ground in resolved.objects["soil"].items():
        assert isinstance(ground, Ground)
        for track_name, track in resolved.objects["track"].items():
            assert isinstance(track, Track)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", PlausibilityWarning)
                check_speed(ground, track, fastest)
            messages += [f"{name}, {track_name}: {warning.message}" for warning in caught]
    return messages
