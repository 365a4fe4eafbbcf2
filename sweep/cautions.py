"""Implausible input of a study: refused before anything runs, or warned of once."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from railvib.errors import InputError, PlausibilityWarning
from railvib.numerics import third_octaves
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.plausibility import check_contact, check_damping, check_speed, check_unevenness
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
    """Return warnings about implausible input; this runs compiled kernels.

    Where the fastest train outruns waves in ground and track, where the contact of track and ground is not
    passive, and which bands rest on extrapolated unevenness.
    """
    speeds = [speed / KMH for speed in resolved.study.sweep.speed_kmh]
    midband = third_octaves.midbands(resolved.study.frequency.minimum_hz, resolved.study.frequency.maximum_hz)
    lower, upper = third_octaves.edges(midband)
    messages: list[str] = []
    for name, ground in resolved.objects["soil"].items():
        assert isinstance(ground, Ground)
        for track_name, track in resolved.objects["track"].items():
            assert isinstance(track, Track)
            with _collect_warnings(f"{name}, {track_name}", messages):
                check_speed(ground, track, max(speeds))
                check_contact(ground, track, float(lower[0]), float(upper[-1]))
    for name, unevenness in resolved.objects["unevenness"].items():
        assert isinstance(unevenness, Unevenness)
        with _collect_warnings(name, messages):
            check_unevenness(unevenness, midband, speeds)
    return messages


@contextmanager
def _collect_warnings(name: str, messages: list[str]) -> Iterator[None]:
    """Append plausibility warnings to the messages, each under a name."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PlausibilityWarning)
        yield
    messages += [f"{name}: {warning.message}" for warning in caught]
