"""Weighted signals of a passage, and what is read from them for each of `railvib.parameters.metric`."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np

from railvib.levels.running import FAST, SLOW
from railvib.levels.weightings import WEIGHTINGS, third_octave
from railvib.numerics import third_octaves

SKIRT = 3.0
"""Factor in frequency from a band's middle beyond which its filter passes nothing, below 1e-6 of energy."""


class Reading(NamedTuple):
    """How a value is read from a weighted signal."""

    name: str
    """The metric, with the band in Hz for one-third octaves."""
    kind: Literal["running", "peak", "dose"]
    unit: str
    time_constant: float
    """Of the running rms, s."""


@dataclass(frozen=True, eq=False)
class Signal:
    """A weighted velocity, and what is read from it."""

    name: str
    response: np.ndarray
    """Response to velocity on the lines, complex (lines,)."""
    lines: slice
    """Lines on which it is not negligible."""
    readings: tuple[Reading, ...]


_READINGS: Mapping[str, tuple[str, Reading]] = MappingProxyType(
    {
        "kb-f-max": ("kb", Reading("kb-f-max", "running", "1", FAST)),
        "v-max-fast": ("velocity", Reading("v-max-fast", "running", "m/s", FAST)),
        "v-max-slow": ("velocity", Reading("v-max-slow", "running", "m/s", SLOW)),
        "ppv": ("velocity", Reading("ppv", "peak", "m/s", 0.0)),
        "vdv": ("wb", Reading("vdv", "dose", "m/s^1.75", 0.0)),
    }
)


def signals(metrics: tuple[str, ...], frequency: np.ndarray, band: np.ndarray) -> Iterator[Signal]:
    """Yield the weighted velocities that some metrics need.

    Parameters
    ----------
    metrics
        Names of metrics, see `railvib.parameters.metric`.
    frequency
        Lines, Hz, (lines,).
    band
        One-third octaves, exact midbands, Hz.
    """
    wanted: dict[str, list[Reading]] = {}
    for metric in metrics:
        if metric in _READINGS:
            weighting, reading = _READINGS[metric]
            wanted.setdefault(weighting, []).append(reading)
    whole = slice(0, frequency.size)
    for weighting, readings in wanted.items():
        response = (
            np.ones(frequency.size, complex)
            if weighting == "velocity"
            else WEIGHTINGS[weighting].of_velocity(frequency)
        )
        yield Signal(weighting, response, whole, tuple(readings))
    if "third-octave-max-fast" in metrics:
        for midband in band:
            name = f"third-octave-max-fast {third_octaves.nominal_label(float(midband))} Hz"
            ends = np.searchsorted(frequency, [midband / SKIRT, midband * SKIRT])
            yield Signal(
                name,
                third_octave(float(midband))(frequency),
                slice(int(ends[0]), int(ends[1])),
                (Reading(name, "running", "m/s", FAST),),
            )
