"""Spectra of one case by one approach: from forces and transfer functions to PSDs and one-third octaves."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, get_args

import numpy as np

from railvib import bands, cost
from railvib.forces import arrivals, axle_numbers, force_matrices
from railvib.full_model import excitation, passage_spectra, quasi_static_spectra
from railvib.moving_roughness import LineIntegrals, axle_pairs, own_products, products
from railvib.receptance import Receptances
from railvib.train_average import TrainIntegrals
from railvib.transfer import Receiver, TransferFunction
from railvib.unevenness import Unevenness
from railvib.vehicle import Train

Approach = Literal[
    "moving-roughness", "moving-roughness-by-axle", "moving-roughness-uncorrelated", "full", "fe-be"
]
APPROACHES: tuple[Approach, ...] = get_args(Approach)

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
    lower, upper = bands.edges(midband)
    return np.asarray(step * np.arange(max(np.floor(lower[0] / step) - 2, 1), np.ceil(upper[-1] / step) + 3))


def highest_excitation(
    midband: np.ndarray, largest_wavenumber: float, speed: float, refinement: int = 1
) -> float:
    """Return the highest frequency of excitation that the full model counts, Hz.

    That of the largest wavenumber at the highest line; not above 10^(1/2) of it, where no response is left
    that it could carry.
    """
    upper = float(bands.edges(midband)[1][-1])
    return float(min(upper + largest_wavenumber * speed / (2.0 * np.pi), np.sqrt(10.0) * upper * refinement))


def spectra(
    approach: Approach,
    train: Train,
    unevenness: Unevenness,
    speed: float,
    midband: np.ndarray,
    rail: Receptances,
    receivers: Mapping[Receiver, TransferFunction],
    integrals: Mapping[Receiver, LineIntegrals] | None = None,
    highest: float | None = None,
    over_train: Mapping[Receiver, TrainIntegrals] | None = None,
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
    receivers
        The receivers' tabulated transfer functions.
    integrals
        Their line integrals on `lines`; needed for the moving roughness.
    highest
        Highest frequency of excitation, Hz; needed for the full model.
    over_train
        Their integrals over the train on `lines`, where the moving roughness is wanted averaged so as well
        (Eq. 26).
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
    matrices = force_matrices(train, rail, f)
    phase = arrivals(train, f, speed)
    if approach == "moving-roughness-uncorrelated":
        force = (np.abs(matrices) ** 2).sum(axis=2)
    else:
        force = np.abs(np.einsum("flp,fp->fl", matrices, phase)) ** 2
    series = [
        _Series("dynamic", "wheel_rail_force", f"axle-{number}", "line", np.nan, force[:, axle] * uneven)
        for axle, number in enumerate(axle_numbers(train))
    ]
    if approach == "full":
        if highest is None:
            raise ValueError("the full model needs the highest frequency of excitation")
        with cost.stage("excitation"):
            excited = excitation(train, rail, unevenness, speed, highest, refinement)
        passing = passage_spectra(receivers, excited, train.length, speed, f)
    elif integrals is None:
        raise ValueError("the moving roughness needs line integrals")
    still = quasi_static_spectra(receivers, train, speed, f)
    for receiver in receivers:
        displacement: dict[str, np.ndarray] = {}
        if integrals is None or approach == "full":
            displacement["line"] = passing[receiver]
        else:
            with cost.stage("line average"):
                pairs = {"line": axle_pairs(integrals[receiver], train.axle_positions)}
                if over_train is not None:
                    pairs["train"] = over_train[receiver].integral
                for averaging, each in pairs.items():
                    mean = _mean(approach, each, matrices, phase)
                    displacement[averaging] = mean / train.length * uneven
        series += _velocities(receiver, f, displacement, still[receiver])
    with cost.stage("bands"):
        psd = np.array([each.psd for each in series])
        mean_square = bands.band_mean_squares(f, psd, midband)
        lower, upper = bands.edges(midband)
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


def _mean(approach: Approach, pairs: np.ndarray, matrices: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Return ∫ |u|² dx per unit unevenness, m³ per m² of unevenness."""
    if approach in ("moving-roughness", "fe-be"):  # Eq. 23: one set of forces, that of all axles together
        product = products(pairs, np.einsum("flp,fp->fl", matrices, phase)[..., None])
        return np.asarray(product[:, 0, 0].real)
    if approach == "moving-roughness-uncorrelated":  # Eq. 28
        return np.asarray(own_products(pairs, matrices).sum(axis=1))
    by_axle = products(pairs, matrices)  # H^p* H^q, each axle's unevenness alone
    return np.asarray(np.einsum("fpq,fp,fq->f", by_axle, phase.conj(), phase, optimize=True).real)  # Eq. 27
