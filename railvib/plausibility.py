"""Warnings about input that is legal but unusual."""

import warnings
from functools import lru_cache

import numpy as np

from railvib.errors import InputError, PlausibilityWarning
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.parameters.units import KMH
from railvib.soil.surface_waves import surface_wave_speeds
from railvib.transfer.critical_speed import critical_speed
from railvib.transfer.tabulate import LOOSEST, TIGHTEST

HIGHEST = 100.0
"""Frequency up to which waves are looked at, Hz, whatever a study asks for: a fast train excites them all."""
LEAST_LOSS_FACTOR = 1e-3
_SURELY_SLOW = 0.4
"""Share of the lowest bound of the ground's wave speeds below which a train outruns nothing."""
_SLOWER_THAN_WAVES = 0.9
"""The same for the ground's own waves: the mass of a track slows down what they carry together, not them."""


@lru_cache(maxsize=256)
def slowest_surface_wave(ground: Ground) -> float:
    """Return the lowest speed of a Rayleigh mode from 1 to 100 Hz, m/s; infinite without one."""
    speeds = [surface_wave_speeds(ground, float(f)) for f in np.geomspace(1.0, HIGHEST, 8)]
    return min((float(each[0]) for each in speeds if each.size), default=np.inf)


def check_tolerance(tolerance: float) -> None:
    """Refuse a tolerance that cannot be met.

    Raises
    ------
    InputError
        Naming the range.
    """
    if not TIGHTEST <= tolerance <= LOOSEST:
        raise InputError(f"tolerance = {tolerance}: must be from {TIGHTEST:g} to {LOOSEST:g}")


def check_damping(ground: Ground) -> None:
    """Refuse a ground without damping, whose transfer functions are infinite at the waves' wavenumbers.

    Raises
    ------
    InputError
        Naming the layer.
    """
    ground.require_damping(LEAST_LOSS_FACTOR)


def check_speed(ground: Ground, track: Track, speed: float) -> None:
    """Warn where a train is faster than the slowest surface wave or the critical speed.

    Parameters
    ----------
    ground, track
        The ground, and the track on it.
    speed
        m/s.

    Warns
    -----
    PlausibilityWarning
        With the speeds in m/s and km/h.
    """
    if speed < _SURELY_SLOW * ground.slowest_speed:
        return
    limits = {"the critical speed of track and ground": critical_speed(ground, track, HIGHEST)}
    if speed >= _SLOWER_THAN_WAVES * ground.slowest_speed:
        limits = {"the slowest surface wave of the ground": slowest_surface_wave(ground), **limits}
    for name, limit in limits.items():
        if speed > limit:
            warnings.warn(
                f"speed {speed:.1f} m/s ({KMH * speed:.0f} km/h) exceeds {name}, {limit:.1f} m/s "
                f"({KMH * limit:.0f} km/h): expect large quasi-static response and a Mach-like wave field",
                PlausibilityWarning,
                stacklevel=3,
            )
