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
from railvib.psd.lines import Lines, lines

_INTERPOLATED = 1e-7
"""Share of a spectrum's largest density that a negative value may have; more is a fault.

Squares are interpolated. Hundreds of wavelengths from the track they fall by orders between the frequencies
of a table.
"""
_NOTHING = 1e-30
"""Density, (m/s)²/Hz, that a negative value may have in any case: 120 dB below the reference of levels."""


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


class WheelShare(NamedTuple):
    """What of the spectra comes from wheels out of round, each wheelset independent of the others."""

    force: np.ndarray
    """One-sided PSDs of the forces, N²/Hz, (lines, axles)."""
    displacement: Mapping[Receiver, Mapping[str, np.ndarray]]
    """One-sided PSDs of displacement by receiver and averaging, m²/Hz, (lines,)."""


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
    def lines(self) -> Lines:
        """The narrow-band lines."""
        return lines(self.band, self.train, self.speed, self.refinement)

    @property
    def frequency(self) -> np.ndarray:
        """Frequencies of the lines, Hz, (n,)."""
        return self.lines.frequency

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
    def wheel_psd(self) -> np.ndarray:
        """One-sided PSD of the roughness of every axle's wheels on the lines, m²/Hz, (n, axles)."""
        per_hz = self.wavenumber_per_hz
        spectra = self.train.wheel_spectra
        psd = np.zeros((self.frequency.size, len(spectra)))
        for axle, spectrum in enumerate(spectra):
            if spectrum is not None:
                psd[:, axle] = spectrum.psd(self.frequency * per_hz) * per_hz
        return psd

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
    wheels: WheelShare | None = None,
) -> Spectra:
    """Return the spectra of forces and velocities, and their mean squares in one-third octaves.

    Parameters
    ----------
    approach, passage
        The approach, and the passage.
    force
        |P|² per unit unevenness, N²/m², (lines, axles).
    displacement
        One-sided PSDs of displacement from the rails' unevenness by receiver and averaging, m²/Hz, (lines,).
    quasi_static
        One-sided PSDs of displacement from the axle loads by receiver, m²/Hz, (lines,).
    wheels
        What comes from wheels out of round besides; None of smooth wheels. Dynamic is then the sum of both,
        and their parts are series of their own, ``rails`` and ``wheels``.
    """
    f, band = passage.frequency, np.asarray(passage.band)
    rails = force * passage.unevenness_psd[:, None]
    series = []
    for axle, number in enumerate(axle_numbers(passage.train)):
        parts = _parts(rails[:, axle], None if wheels is None else wheels.force[:, axle])
        series += [
            _Series(contribution, "wheel_rail_force", f"axle-{number}", "line", np.nan, psd)
            for contribution, psd in parts.items()
        ]
    for receiver, psd in quasi_static.items():
        from_wheels = None if wheels is None else wheels.displacement[receiver]
        series += _velocities(receiver, f, displacement[receiver], from_wheels, psd)
    with cost.stage("bands"), threads.single():
        psds = _without_negatives(np.array([row.psd for row in series]))
        mean_square = passage.lines.mean_squares(psds)
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


def _without_negatives(psds: np.ndarray) -> np.ndarray:
    """Return densities (series, lines) with zero where interpolation has left a small negative value."""
    allowed = np.maximum(_INTERPOLATED * psds.max(axis=1, keepdims=True), _NOTHING)
    return np.where((psds < 0.0) & (psds >= -allowed), 0.0, psds)


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
    rails: Mapping[str, np.ndarray],
    wheels: Mapping[str, np.ndarray] | None,
    quasi_static: np.ndarray,
) -> list[_Series]:
    """Return the rows of one receiver: quasi-static, dynamic with its parts, and total velocity."""
    name, offset = receiver.name, receiver.offset_m
    squared = (2.0 * np.pi * frequency) ** 2
    rows = [_Series("quasi-static", "velocity", name, "line", offset, quasi_static * squared)]
    for averaging in rails:
        parts = _parts(rails[averaging], None if wheels is None else wheels[averaging])
        parts["total"] = parts["dynamic"] + quasi_static
        rows += [
            _Series(contribution, "velocity", name, averaging, offset, psd * squared)
            for contribution, psd in parts.items()
        ]
    return rows


def _parts(rails: np.ndarray, wheels: np.ndarray | None) -> dict[str, np.ndarray]:
    """Return the dynamic PSD, and its parts where there are two."""
    if wheels is None:
        return {"dynamic": rails}
    return {"dynamic": rails + wheels, "rails": rails, "wheels": wheels}
