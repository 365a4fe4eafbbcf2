"""Spectra of one case by one approach: from forces and transfer functions to PSDs and one-third octaves."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from railvib import cost
from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import AxleEquations, arrivals, axle_forces, axle_numbers
from railvib.numerics import third_octaves, threads
from railvib.parameters.approach import Approach
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.psd.excitation import excitation
from railvib.psd.full_model import passage_spectra
from railvib.psd.line_integrals import LineIntegrals
from railvib.psd.moving_roughness import axle_pairs, force_products, line_means, products
from railvib.psd.train_average import TrainIntegrals
from railvib.transfer.table import Receiver, TransferFunction

_STEPS_PER_RIPPLE = 8
_COARSEST_STEP = 0.125
LINES_AT_ONCE = 128
"""Lines of a standing train whose matrices are made together: few enough to stay in the cache."""


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


def spectra(
    approach: Approach,
    train: Train,
    unevenness: Unevenness,
    speed: float,
    midband: np.ndarray,
    rail: Receptances,
    quasi_static: Mapping[Receiver, np.ndarray],
    receivers: Mapping[Receiver, TransferFunction] | None = None,
    integrals: Mapping[Receiver, LineIntegrals] | None = None,
    highest: float | None = None,
    over_train: Mapping[Receiver, TrainIntegrals] | None = None,
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> Spectra:
    """Predict the spectra of one case by one approach.

    Parameters
    ----------
    approach
        Which approach.
    train, unevenness, speed
        The train, the rails' unevenness, and the speed in m/s.
    midband
        One-third octaves, exact midband frequencies, Hz.
    rail
        The rail's receptances: standing for the moving roughness, moving at the train's speed for the full
        model.
    quasi_static
        The receivers' PSDs of displacement from the axle loads on `lines`, m²/Hz, (n,) each.
    receivers
        Their tabulated transfer functions, which may be loaded when asked for; needed for the full model.
    integrals
        Their line integrals at the train's axle distances; needed for the moving roughness.
    highest
        Highest frequency of excitation, Hz; needed for the full model.
    over_train
        Their integrals over the train on `lines`, where the moving roughness is wanted averaged so as well
        (Eq. 26).
    tolerance
        Relative error allowed in the excitation of the full model.
    refinement
        For studies of convergence: 2 halves the step of the lines and of the full model's excitation.

    Returns
    -------
    Spectra
        Wheel–rail forces, and velocities of the rail and the ground.
    """
    f = lines(midband, line_step(train.length, speed, refinement))
    per_hz = 2.0 * np.pi / speed
    uneven = unevenness.psd(f * per_hz) * per_hz
    phase = arrivals(train, f, speed)
    if approach == "full":
        if highest is None or receivers is None:
            raise ValueError("the full model needs transfer functions and the highest excitation")
        force = np.abs(axle_forces(train, rail, f, phase)) ** 2
        with cost.stage("excitation"):
            excited = excitation(train, rail, unevenness, speed, highest, tolerance, refinement)
        passing = passage_spectra(receivers, excited, train.length, speed, f)
        displacement = {receiver: {"line": psd} for receiver, psd in passing.items()}
    elif integrals is None:
        raise ValueError("the moving roughness needs line integrals")
    else:
        force, means = _standing(approach, train, rail, f, phase, integrals, over_train or {})
        displacement = {
            receiver: {name: mean / train.length * uneven for name, mean in each.items()}
            for receiver, each in means.items()
        }
    series = [
        _Series("dynamic", "wheel_rail_force", f"axle-{number}", "line", np.nan, force[:, axle] * uneven)
        for axle, number in enumerate(axle_numbers(train))
    ]
    for receiver, still in quasi_static.items():
        series += _velocities(receiver, f, displacement[receiver], still)
    with cost.stage("bands"), threads.single():
        psd = np.array([each.psd for each in series])
        mean_square = third_octaves.band_mean_squares(f, psd, midband)
        lower, upper = third_octaves.edges(midband)
        share = unevenness.extrapolated_share(lower * per_hz, upper * per_hz)
    return Spectra(
        frequency=f,
        band=midband,
        psd=psd,
        mean_square=mean_square,
        extrapolated_share=np.asarray(share),
        contribution=np.array([each.contribution for each in series]),
        quantity=np.array([each.quantity for each in series]),
        receiver=np.array([each.receiver for each in series]),
        averaging=np.array([each.averaging for each in series]),
        offset_m=np.array([each.offset for each in series]),
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
    receiver: Receiver, frequency: np.ndarray, displacement: Mapping[str, np.ndarray], still: np.ndarray
) -> list[_Series]:
    """Return the rows of one receiver: dynamic, quasi-static and total velocity."""
    name, offset = ("rail", np.nan) if receiver == "rail" else ("ground", float(receiver))
    squared = (2.0 * np.pi * frequency) ** 2
    rows = [_Series("quasi-static", "velocity", name, "line", offset, still * squared)]
    for averaging, moving in displacement.items():
        rows.append(_Series("dynamic", "velocity", name, averaging, offset, moving * squared))
        rows.append(_Series("total", "velocity", name, averaging, offset, (moving + still) * squared))
    return rows


Means = dict[Receiver, dict[str, np.ndarray]]
"""∫ |u|² dx on some lines by receiver and averaging, m³ per m² of unevenness."""


def _standing(
    approach: Approach,
    train: Train,
    rail: Receptances,
    frequency: np.ndarray,
    phase: np.ndarray,
    integrals: Mapping[Receiver, LineIntegrals],
    over_train: Mapping[Receiver, TrainIntegrals],
) -> tuple[np.ndarray, Means]:
    """Return what a standing train does per unit unevenness: |P|², (lines, axles), N²/m², and ∫ |u|² dx."""
    force = np.empty(phase.shape)
    position = train.axle_positions
    parts: list[Means] = []
    with cost.stage("line average"):
        distance = next(iter(integrals.values())).distance
        on_lines = {receiver: each.at(frequency) for receiver, each in integrals.items()}
    equations = AxleEquations(train, rail, frequency)
    # One set of forces takes no matrices.
    at_once = frequency.size if approach == "moving-roughness" else LINES_AT_ONCE
    for start in range(0, frequency.size, at_once):
        here = slice(start, start + at_once)
        if approach == "moving-roughness-by-axle":
            matrices = equations.matrices(here)
            sets = matrices @ phase[here, :, None]
            with cost.stage("line average"):
                parts.append(
                    _means_by_axle(position, matrices, phase[here], here, distance, on_lines, over_train)
                )
        else:
            if approach == "moving-roughness-uncorrelated":  # Eq. 28: each axle's unevenness alone
                sets = equations.matrices(here)
            else:  # Eq. 23: one set of forces, that of all axles together
                sets = equations.forces(here, phase[here, :, None])
            with cost.stage("line average"):
                parts.append(_means(position, sets, here, distance, on_lines, over_train))
        floats = np.ascontiguousarray(sets).view(float)
        force[here] = np.einsum("lan,lan->la", floats, floats)
    joined = {
        receiver: {name: np.concatenate([part[receiver][name] for part in parts]) for name in each}
        for receiver, each in parts[0].items()
    }
    return force, joined


def _means(
    axle_position: np.ndarray,
    sets: np.ndarray,
    rows: slice,
    distance: np.ndarray,
    integrals: Mapping[Receiver, np.ndarray],
    over_train: Mapping[Receiver, TrainIntegrals],
) -> Means:
    """Return ∫ |u|² dx summed over sets of forces (lines, axles, sets), each alone."""
    here = {receiver: each[rows] for receiver, each in integrals.items()}
    means = {
        receiver: {"line": mean} for receiver, mean in line_means(here, distance, axle_position, sets).items()
    }
    if over_train:
        product = force_products(sets)
        for receiver, each in over_train.items():
            means[receiver]["train"] = np.einsum("flm,flm->f", product, each.integral[rows]).real
    return means


def _means_by_axle(
    axle_position: np.ndarray,
    matrices: np.ndarray,
    phase: np.ndarray,
    rows: slice,
    distance: np.ndarray,
    integrals: Mapping[Receiver, np.ndarray],
    over_train: Mapping[Receiver, TrainIntegrals],
) -> Means:
    """Return ∫ |u|² dx from the products H^p* H^q of the responses to each axle's unevenness (Eq. 27)."""
    means: Means = {}
    for receiver, each in integrals.items():
        pairs = {"line": axle_pairs(each[rows], distance, axle_position)}
        if over_train:
            pairs["train"] = over_train[receiver].integral[rows]
        means[receiver] = {
            averaging: np.einsum(
                "fpq,fp,fq->f", products(pair, matrices), phase.conj(), phase, optimize=True
            ).real
            for averaging, pair in pairs.items()
        }
    return means
