"""Frequencies up to which transfer functions are needed: for receptances, axle loads and unevenness."""

import numpy as np

from railvib.parameters.ground import Ground
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.transfer.nodes import TOP, largest_wavenumber, negligible_beyond


def highest_tabulated_frequency(
    track: Track, maximum_frequency: float, speed: float, refinement: int = 1
) -> float:
    """Return the frequency up to which receptances up to another frequency need the rail's tables, Hz."""
    return maximum_frequency + largest_wavenumber(track, refinement) * abs(speed) / (2.0 * np.pi)


def highest_quasi_static_frequency(ground: Ground, track: Track, receiver: Receiver, speed: float) -> float:
    """Return the frequency up to which the response to loads at a speed in m/s needs tables, Hz.

    Beyond, it is negligible, or on the track known in closed form; infinite for loads that a wave can follow.
    """
    distance = receiver.distance(track.half_width)
    if TOP * speed >= ground.slowest_speed:
        return np.inf
    return min(negligible_beyond(distance), largest_wavenumber(track)) * speed / (2.0 * np.pi)


def highest_excitation(
    receiving_frequency: float, largest_wavenumber: float, speed: float, refinement: int = 1
) -> float:
    """Return the highest frequency of excitation that the full model counts, Hz.

    A line at f hears the excitation at f + κv/2π through H̃(κ, f). All wavenumbers κ up to half the largest
    of the tables count, where the rail on its pads carries all but a hundredth of the load alone. Of those
    beyond, excitations up to 10^(1/2) of the highest line count.

    Parameters
    ----------
    receiving_frequency
        The highest line, Hz.
    largest_wavenumber
        Of the tables, rad/m, see `railvib.transfer.nodes`.
    speed
        m/s.
    refinement
        For studies of convergence: by how much the limit of 10^(1/2) is raised.
    """
    shift = largest_wavenumber * speed / (2.0 * np.pi)
    highest = max(receiving_frequency + 0.5 * shift, np.sqrt(10.0) * receiving_frequency * refinement)
    return float(min(receiving_frequency + shift, highest))
