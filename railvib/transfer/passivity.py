"""Where the contact of track and ground gives energy instead of taking it.

The load on the ground is uniform over the width of the track, and the track follows the ground on the centre
line. Where half a wavelength of the ground is shorter than half that width the two need not agree, and Im
σ_R(0) may be positive: the model's receptance is then not that of any real contact. A track that follows the
mean displacement over its width gives no energy at any frequency: the mean weighs Im Q33 < 0 with a square.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.soil.barycentric import Start
from railvib.soil.rational_fit import fit_flexibility
from railvib.transfer.compliance_under_track import compliance_under_track
from railvib.transfer.track_response import track_response

_STEPS_PER_OCTAVE = 12
_BISECTIONS = 9
_FIT_TOLERANCE = 1e-7
_PANELS = 300
_NODE, _WEIGHT = legendre.leggauss(8)


def nonpassive_ranges(
    ground: Ground, track: Track, lowest: float, highest: float
) -> list[tuple[float, float]]:
    """Return the ranges of frequency in which Im σ_R(0) > 0 for a standing load, each (from, to) in Hz.

    Parameters
    ----------
    ground, track
        The damped ground, and the track on it.
    lowest, highest
        Frequencies between which they are sought, Hz; ranges end there at the latest.

    Notes
    -----
    docs/conventions.md, ground and track. Twelve frequencies per octave are tried, and the ends of ranges
    are found to 0.1 %.
    """
    if track.follows_mean or highest <= _passive_up_to(ground, track):
        return []
    octave = 2.0 ** np.ceil(np.log2(highest))
    return [
        (max(low, lowest), min(high, highest))
        for low, high in _nonpassive_ranges(ground, track, octave)
        if low <= highest and high >= lowest
    ]


def _passive_up_to(ground: Ground, track: Track) -> float:
    """Return a frequency up to which the contact is passive, Hz.

    Im Q33 is negative, and so is Im C(β, 0) as long as sin(γb)/(γb) is positive for every wave.
    """
    return ground.slowest_speed / (4.0 * track.half_width)


@lru_cache(maxsize=256)
def _nonpassive_ranges(ground: Ground, track: Track, highest: float) -> tuple[tuple[float, float], ...]:
    """Return all ranges up to a frequency."""
    lowest = _passive_up_to(ground, track)
    start: Start | None = None

    def excess(frequency: float) -> float:
        nonlocal start
        receptance, start = _direct_receptance(ground, track, frequency, start)
        return receptance.imag

    steps = int(np.ceil(_STEPS_PER_OCTAVE * np.log2(highest / lowest))) + 1
    frequency = np.geomspace(lowest, highest, steps)
    positive = np.array([excess(float(f)) > 0.0 for f in frequency])
    ranges = []
    for first, last in _runs(positive):
        low = _crossing(excess, frequency[first], frequency[first - 1]) if first > 0 else lowest
        high = _crossing(excess, frequency[last], frequency[last + 1]) if last + 1 < steps else highest
        ranges.append((float(low), float(high)))
    return tuple(ranges)


def _runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """Return first and last index of every run of true values."""
    change = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [(int(first), int(end) - 1) for first, end in zip(change[::2], change[1::2], strict=True)]


def _crossing(excess: Callable[[float], float], inside: float, outside: float) -> float:
    for _ in range(_BISECTIONS):
        middle = float(np.sqrt(inside * outside))
        inside, outside = (middle, outside) if excess(middle) > 0.0 else (inside, middle)
    return inside


def _direct_receptance(
    ground: Ground, track: Track, frequency: float, start: Start | None
) -> tuple[complex, Start]:
    """Return σ_R(0) of a standing load, m/N, and what a neighbouring frequency's fit starts from."""
    omega = 2.0 * np.pi * frequency
    fit = fit_flexibility(ground, frequency, _FIT_TOLERANCE, start)
    # Over the waves of the ground, and beyond as far as the rail bends.
    waves = np.linspace(0.0, 1.5 * omega / ground.slowest_speed, _PANELS)
    bending = ((track.pad_stiffness + omega**2 * track.rail_mass) / track.rail_bending_stiffness) ** 0.25
    edge = np.concatenate([waves, np.geomspace(waves[-1], waves[-1] + 30.0 * bending, _PANELS // 5)[1:]])
    half = 0.5 * np.diff(edge)[:, None]
    beta = (0.5 * (edge[1:] + edge[:-1])[:, None] + half * _NODE).ravel()
    compliance = compliance_under_track(fit, beta, track)
    response, _force = track_response(track, beta, omega, compliance)
    return complex((response * (half * _WEIGHT).ravel()).sum() / np.pi), fit.start
