"""Warnings about input that is legal but unusual.

Checks that compute waves import the physics themselves: a driver checks without compiled kernels what can be.
"""

import warnings
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from railvib.errors import InputError, PlausibilityWarning
from railvib.numerics import third_octaves
from railvib.parameters.ground import Ground
from railvib.parameters.speed import FASTEST_KMH, SLOWEST_KMH
from railvib.parameters.track import Track
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.parameters.validation import warn

TIGHTEST, LOOSEST = 1e-6, 1e-2
"""Tolerances that can be asked for; the rational fits are asked for a millionth of them."""
HIGHEST = 100.0
"""Frequency up to which waves are looked at, Hz, whatever a study asks for: a fast train excites them all."""
LEAST_LOSS_FACTOR = 1e-3
_SURELY_SLOW = 0.4
"""Share of the lowest bound of the ground's wave speeds below which a train outruns nothing."""
_SLOWER_THAN_WAVES = 0.9
"""The same for the ground's own waves: the mass of a track slows down what they carry together, not them."""

_MOSTLY_EXTRAPOLATED = 0.5
"""Share of a band's unevenness from outside the form's range above which that is said."""

_BESIDE = 0.97
"""Share of a frequency down to which the contact must be passive: just above such a range tables do not
resolve the sharp peak of the wave that was not.
"""


@lru_cache(maxsize=256)
def slowest_surface_wave(ground: Ground) -> float:
    """Return the lowest speed of a Rayleigh mode from 1 to 100 Hz, m/s; infinite without one."""
    from railvib.soil.surface_waves import slowest_surface_wave_speed

    return min(slowest_surface_wave_speed(ground, float(f)) for f in np.geomspace(1.0, HIGHEST, 8))


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


def check_inputs(ground: Ground, track: Track, speed: float) -> None:
    """Refuse a speed that no train has; warn about what is unusual in a ground and a track.

    Parameters
    ----------
    ground, track
        The ground, and the track on it.
    speed
        m/s.

    Raises
    ------
    InputError
        With the range of speeds.

    Warns
    -----
    PlausibilityWarning
        With the path of each value, such as ``ground.layers[0].density_kg_m3``.
    """
    if not SLOWEST_KMH <= KMH * speed <= FASTEST_KMH:
        raise InputError(
            f"speed = {speed} m/s: must be from {SLOWEST_KMH / KMH:.3g} to {FASTEST_KMH / KMH:.3g} m/s, "
            f"{SLOWEST_KMH:g} to {FASTEST_KMH:g} km/h"
        )
    warn(ground.cautions(), "ground")
    warn(track.cautions(), "track")


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
    from railvib.transfer.critical_speed import critical_speed

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


def check_contact(ground: Ground, track: Track, lowest: float, highest: float) -> None:
    """Warn where the contact of track and ground is not passive: Im σ_R(0) > 0 for a standing load.

    Parameters
    ----------
    ground, track
        The ground, and the track on it.
    lowest, highest
        Range of the frequencies asked for, Hz.

    Warns
    -----
    PlausibilityWarning
        With the ranges of frequency, and what helps.
    """
    from railvib.transfer.passivity import nonpassive_ranges

    ranges = nonpassive_ranges(ground, track, _BESIDE * lowest, highest)
    if ranges:
        spans = " and ".join(_range_label(f"{low:.0f}", f"{high:.0f}") for low, high in ranges)
        warnings.warn(
            f"the contact of track and ground is not passive at {spans} Hz (Im of the rail's receptance is "
            "positive): the load is uniform over a contact width that exceeds half a wavelength "
            'there, and levels from there on are not to be trusted; coupling = "mean" on the track, a '
            "narrower contact_width_m or a lower maximum frequency avoids it",
            PlausibilityWarning,
            stacklevel=3,
        )


def check_unevenness(unevenness: Unevenness, midband: np.ndarray, speeds: Sequence[float]) -> None:
    """Warn where half of a band's unevenness or more lies outside the wavelengths of its form.

    Parameters
    ----------
    unevenness
        The unevenness.
    midband
        One-third octaves, exact midband frequencies, Hz.
    speeds
        m/s. The slowest and the fastest decide: they reach the shortest and the longest wavelengths.

    Warns
    -----
    PlausibilityWarning
        With the bands.
    """
    speed = np.array(sorted({min(speeds), max(speeds)}))[:, None]
    lower, upper = (2.0 * np.pi * edge / speed for edge in third_octaves.edges(midband))
    extrapolated = (unevenness.extrapolated_share(lower, upper) >= _MOSTLY_EXTRAPOLATED).any(axis=0)
    if extrapolated.any():
        label = [third_octaves.nominal_label(float(band)) for band in midband]
        change = np.flatnonzero(np.diff(np.concatenate([[False], extrapolated, [False]])))
        spans = [
            _range_label(label[first], label[end - 1])
            for first, end in zip(change[::2], change[1::2], strict=True)
        ]
        shortest, longest = unevenness.validity
        warnings.warn(
            f"{extrapolated.sum()} of {midband.size} bands ({' and '.join(spans)} Hz) rest on unevenness "
            f"that is extrapolated beyond its wavelengths, {shortest:g} to {longest:g} m, at "
            f"{' or '.join(f'{KMH * v:.4g}' for v in speed[:, 0])} km/h: see extrapolated_share",
            PlausibilityWarning,
            stacklevel=3,
        )


def _range_label(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"
