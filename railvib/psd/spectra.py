"""Spectra of one case by one approach: narrow-band lines, and PSDs in one-third octaves."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from railvib import cost
from railvib.forces.wheel_rail import axle_numbers, axle_phases
from railvib.numerics import third_octaves, threads
from railvib.parameters.approach import Approach
from railvib.parameters.receiver import Receiver
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train

_STEPS_PER_RIPPLE = 8
_COARSEST_STEP = 0.125


@dataclass(frozen=True)
class Spectra:
    """Narrow-band and one-third-octave spectra of one case by one approach."""

    frequency: np.ndarray = field(
        metadata={"dims": ("frequency",), "unit": "Hz", "description": "narrow-band lines"}
    )
    band: np.ndarray = field(
        metadata={"dims": ("band",), "unit": "Hz", "description": "exact midband frequency"}
    )
    psd: np.ndarray = field(
        metadata={
            "dims": ("series", "frequency"),
            "unit": "(m/s)2/Hz or N2/Hz",
            "description": "one-sided PSD",
        }
    )
    mean_square: np.ndarray = field(
        metadata={
            "dims": ("series", "band"),
            "unit": "(m/s)2 or N2",
            "description": "mean square in the band",
        }
    )
    extrapolated_share: np.ndarray = field(
        metadata={
            "dims": ("band",),
            "unit": "1",
            "description": "share of unevenness beyond its form's range of validity",
        }
    )
    contribution: np.ndarray = field(
        metadata={"dims": ("series",), "unit": "", "description": "dynamic, quasi-static or total"}
    )
    quantity: np.ndarray = field(
        metadata={"dims": ("series",), "unit": "", "description": "wheel_rail_force or velocity"}
    )
    receiver: np.ndarray = field(
        metadata={"dims": ("series",), "unit": "", "description": "axle-1 (leading) …, rail, ground"}
    )
    averaging: np.ndarray = field(
        metadata={"dims": ("series",), "unit": "", "description": "line or train (Eq. 26)"}
    )
    offset_m: np.ndarray = field(
        metadata={"dims": ("series",), "unit": "m", "description": "distance from the centre line"}
    )
    approach: str


def line_step(train_length: float, speed: float, refinement: int = 1) -> float:
    """Return the step of the narrow-band lines, Hz: the largest 2ⁿ or 1.5·2ⁿ up to v/(8L) and 1/8 Hz.

    The spectra ripple with period v/L. Two steps per octave, so that neighbouring speeds share their lines.
    """
    largest = min(speed / (_STEPS_PER_RIPPLE * train_length), _COARSEST_STEP)
    octave = 2.0 ** np.floor(np.log2(largest))
    return float(1.5 * octave if 1.5 * octave <= largest else octave) / refinement


def lines(midband: np.ndarray, step: float) -> np.ndarray:
    """Return the narrow-band lines that cover some one-third octaves: multiples of a step, Hz."""
    lower, upper = third_octaves.edges(midband)
    return np.asarray(step * np.arange(max(np.floor(lower[0] / step) - 2, 1), np.ceil(upper[-1] / step) + 3))


def highest_excitation(
    midband: np.ndarray, largest_wavenumber: float, speed: float, refinement: int = 1
) -> float:
    """Return the highest frequency of excitation that the full model counts, Hz.

    That of the largest wavenumber at the highest line; not above 10^(1/2) of it, where no response is left
    that it could carry.
    """
    upper = float(third_octaves.edges(midband)[1][-1])
    return float(min(upper + largest_wavenumber * speed / (2.0 * np.pi), np.sqrt(10.0) * upper * refinement))


@dataclass(frozen=True)
class Passage:
    """A train over uneven rails at a speed, and the one-third octaves in which its spectra are asked for.

    Attributes
    ----------
    train, unevenness
        The train, and the rails' unevenness.
    speed
        m/s.
    band
        One-third octaves, exact midband frequencies, Hz, ascending.
    refinement
        For studies of convergence: 2 halves the step of the lines and of the full model's excitation.
    """

    train: Train
    unevenness: Unevenness
    speed: float
    band: tuple[float, ...]
    refinement: int = 1

    @cached_property
    def frequency(self) -> np.ndarray:
        """The narrow-band lines, Hz, (n,)."""
        return lines(np.asarray(self.band), line_step(self.train.length, self.speed, self.refinement))

    @property
    def wavenumber_per_hz(self) -> float:
        """Wavenumber of the unevenness that excites 1 Hz, rad/m/Hz."""
        return 2.0 * np.pi / self.speed

    @cached_property
    def unevenness_psd(self) -> np.ndarray:
        """One-sided PSD of the unevenness on the lines, m²/Hz, (n,)."""
        per_hz = self.wavenumber_per_hz
        return np.asarray(self.unevenness.psd(self.frequency * per_hz) * per_hz)

    @cached_property
    def phase(self) -> np.ndarray:
        """Phases of the unevenness at the axles (Eq. 20, 21), complex (n, axles)."""
        return axle_phases(self.train, self.frequency, self.speed)


def assemble(
    approach: Approach,
    passage: Passage,
    force: np.ndarray,
    displacement: Mapping[Receiver, Mapping[str, np.ndarray]],
    quasi_static: Mapping[Receiver, np.ndarray],
) -> Spectra:
    """Return the spectra of forces and velocities, and their mean squares in one-third octaves.

    Parameters
    ----------
    approach, passage
        The approach, and the passage.
    force
        |P|² per unit unevenness, N²/m², (lines, axles).
    displacement
        One-sided PSDs of dynamic displacement by receiver and averaging, m²/Hz, (lines,).
    quasi_static
        One-sided PSDs of displacement from the axle loads by receiver, m²/Hz, (lines,).
    """
    f, band = passage.frequency, np.asarray(passage.band)
    uneven = passage.unevenness_psd
    series = [
        _Series("dynamic", "wheel_rail_force", f"axle-{number}", "line", np.nan, force[:, axle] * uneven)
        for axle, number in enumerate(axle_numbers(passage.train))
    ]
    for receiver, psd in quasi_static.items():
        series += _velocities(receiver, f, displacement[receiver], psd)
    with cost.stage("bands"), threads.single():
        psds = np.array([row.psd for row in series])
        mean_square = third_octaves.band_mean_squares(f, psds, band)
        lower, upper = third_octaves.edges(band)
        per_hz = passage.wavenumber_per_hz
        share = passage.unevenness.extrapolated_share(lower * per_hz, upper * per_hz)
    return Spectra(
        frequency=f,
        band=band,
        psd=psds,
        mean_square=mean_square,
        extrapolated_share=np.asarray(share),
        contribution=np.array([row.contribution for row in series]),
        quantity=np.array([row.quantity for row in series]),
        receiver=np.array([row.receiver for row in series]),
        averaging=np.array([row.averaging for row in series]),
        offset_m=np.array([row.offset for row in series]),
        approach=approach,
    )


class _Series(NamedTuple):
    """One row of `Spectra`."""

    contribution: str
    quantity: str
    receiver: str
    averaging: str
    offset: float
    psd: np.ndarray


def _velocities(
    receiver: Receiver,
    frequency: np.ndarray,
    displacement: Mapping[str, np.ndarray],
    quasi_static: np.ndarray,
) -> list[_Series]:
    """Return the rows of one receiver: dynamic, quasi-static and total velocity."""
    name, offset = receiver.name, receiver.offset_m
    squared = (2.0 * np.pi * frequency) ** 2
    rows = [_Series("quasi-static", "velocity", name, "line", offset, quasi_static * squared)]
    for averaging, dynamic in displacement.items():
        rows.append(_Series("dynamic", "velocity", name, averaging, offset, dynamic * squared))
        rows.append(_Series("total", "velocity", name, averaging, offset, (dynamic + quasi_static) * squared))
    return rows
