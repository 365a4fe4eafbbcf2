"""Warnings about input that is legal but unusual."""

import warnings
from functools import lru_cache

import numpy as np

from railvib.errors import PlausibilityWarning
from railvib.ground import Ground
from railvib.surface_waves import critical_speed, surface_wave_speeds
from railvib.track import Track

_SURELY_SLOW = 0.4
"""Share of the lowest bound of the ground's wave speeds below which a train outruns nothing."""


@lru_cache(maxsize=256)
def slowest_surface_wave(ground: Ground, maximum_frequency: float) -> float:
    """Return the lowest speed of a Rayleigh mode from 1 Hz up to a frequency in Hz, m/s; or infinity."""
    speeds = [
        surface_wave_speeds(ground, float(f)) for f in np.geomspace(1.0, max(maximum_frequency, 2.0), 8)
    ]
    return min((float(each[0]) for each in speeds if each.size), default=np.inf)


def check_speed(ground: Ground, track: Track, speed: float, maximum_frequency: float = 100.0) -> None:
    """Warn where a train is faster than the slowest surface wave or the critical speed.

    Parameters
    ----------
    ground, track
        The ground, and the track on it.
    speed
        m/s.
    maximum_frequency
        Frequencies up to this one, Hz, are looked at.

    Warns
    -----
    PlausibilityWarning
        With the speeds in m/s and km/h.
    """
    if speed < _SURELY_SLOW * ground.slowest_speed:
        return
    for name, limit in (
        ("the slowest surface wave of the ground", slowest_surface_wave(ground, maximum_frequency)),
        ("the critical speed of track and ground", critical_speed(ground, track, maximum_frequency)),
    ):
        if speed > limit:
            warnings.warn(
                f"speed {speed:.1f} m/s ({3.6 * speed:.0f} km/h) exceeds {name}, {limit:.1f} m/s "
                f"({3.6 * limit:.0f} km/h): expect large quasi-static response and a Mach-like wave field",
                PlausibilityWarning,
                stacklevel=3,
            )
