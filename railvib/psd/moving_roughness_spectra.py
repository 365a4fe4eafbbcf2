"""Spectra of a case by moving roughness: the roughness is pulled through under a standing train."""

from collections.abc import Mapping, Sequence

import numpy as np

from railvib import cost
from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import AxleEquations
from railvib.parameters.approach import Approach
from railvib.parameters.receiver import Receiver
from railvib.psd.line_integrals import LineIntegrals
from railvib.psd.lines import LINES_AT_ONCE
from railvib.psd.moving_roughness import axle_pairs, force_products, line_means, products
from railvib.psd.spectra import Passage, Spectra, WheelShare, assemble
from railvib.psd.train_average import TrainIntegrals

Means = dict[Receiver, dict[str, np.ndarray]]
"""∫ |u|² dx on some lines by receiver and averaging, m³ per m² of unevenness."""


def moving_roughness_spectra(
    approach: Approach,
    passage: Passage,
    rail: Receptances,
    quasi_static: Mapping[Receiver, np.ndarray],
    integrals: Mapping[Receiver, LineIntegrals],
    over_train: Mapping[Receiver, TrainIntegrals],
) -> Spectra:
    """Predict the spectra of a passage by one form of moving roughness.

    Parameters
    ----------
    approach
        Axles together (Eq. 23), by axle (Eq. 27), uncorrelated (Eq. 28), or on the FE/BE model.
    passage
        The train, the unevenness, the speed and the bands.
    rail
        The rail's standing receptances.
    quasi_static
        The receivers' PSDs of displacement from the axle loads on the lines, m²/Hz, (n,) each.
    integrals
        The receivers' line integrals at the train's axle distances.
    over_train
        Their integrals over the train, where the average over the train is asked for too (Eq. 26); else
        empty.
    """
    force, means = _standing(approach, passage, rail, integrals, over_train)
    displacement = {
        receiver: {
            averaging: mean / passage.train.length * passage.unevenness_psd
            for averaging, mean in by_averaging.items()
        }
        for receiver, by_averaging in means.items()
    }
    wheels = None
    if passage.train.has_rough_wheels:
        wheels = _wheel_share(passage, rail, integrals, over_train)
    return assemble(approach, passage, force, displacement, quasi_static, wheels)


def _wheel_share(
    passage: Passage,
    rail: Receptances,
    integrals: Mapping[Receiver, LineIntegrals],
    over_train: Mapping[Receiver, TrainIntegrals],
) -> WheelShare:
    """Return what comes from the wheels: as Eq. 28, each axle's roughness alone, with a PSD of its own."""
    train, frequency, rough = passage.train, passage.frequency, passage.wheel_psd
    (axles,) = np.nonzero(rough.any(axis=0))
    force = np.empty(rough.shape)
    parts: list[Means] = []
    with cost.stage("line average"):
        distance = next(iter(integrals.values())).grid.distance
        on_lines = {receiver: integral.at(frequency) for receiver, integral in integrals.items()}
    equations = AxleEquations(train, rail, frequency)
    for start in range(0, frequency.size, LINES_AT_ONCE):
        rows = slice(start, start + LINES_AT_ONCE)
        sets = equations.matrices(rows)[:, :, axles] * np.sqrt(rough[rows, None, axles])
        with cost.stage("line average"):
            parts.append(_means(train.axle_positions, sets, rows, distance, on_lines, over_train))
        floats = np.ascontiguousarray(sets).view(float)
        force[rows] = np.einsum("lan,lan->la", floats, floats)
    displacement = {
        receiver: {averaging: mean / train.length for averaging, mean in by_averaging.items()}
        for receiver, by_averaging in _join(parts).items()
    }
    return WheelShare(force, displacement)


def _standing(
    approach: Approach,
    passage: Passage,
    rail: Receptances,
    integrals: Mapping[Receiver, LineIntegrals],
    over_train: Mapping[Receiver, TrainIntegrals],
) -> tuple[np.ndarray, Means]:
    """Return |P|² per unit unevenness, N²/m², (lines, axles), and the means ∫ |u|² dx."""
    train, frequency, phase = passage.train, passage.frequency, passage.phase
    force = np.empty(phase.shape)
    position = train.axle_positions
    parts: list[Means] = []
    with cost.stage("line average"):
        distance = next(iter(integrals.values())).grid.distance
        on_lines = {receiver: integral.at(frequency) for receiver, integral in integrals.items()}
    equations = AxleEquations(train, rail, frequency)
    # One set of forces takes no matrices.
    at_once = frequency.size if approach == "moving-roughness" else LINES_AT_ONCE
    for start in range(0, frequency.size, at_once):
        rows = slice(start, start + at_once)
        if approach == "moving-roughness-by-axle":
            matrices = equations.matrices(rows)
            sets = matrices @ phase[rows, :, None]
            with cost.stage("line average"):
                parts.append(
                    _means_by_axle(position, matrices, phase[rows], rows, distance, on_lines, over_train)
                )
        else:
            if approach == "moving-roughness-uncorrelated":  # Eq. 28: each axle's unevenness alone
                sets = equations.matrices(rows)
            else:  # Eq. 23: one set of forces, that of all axles together
                sets = equations.forces(rows, phase[rows, :, None])
            with cost.stage("line average"):
                parts.append(_means(position, sets, rows, distance, on_lines, over_train))
        floats = np.ascontiguousarray(sets).view(float)
        force[rows] = np.einsum("lan,lan->la", floats, floats)
    return force, _join(parts)


def _join(parts: Sequence[Means]) -> Means:
    """Return the means on all lines, from those on some at a time."""
    return {
        receiver: {name: np.concatenate([part[receiver][name] for part in parts]) for name in by_averaging}
        for receiver, by_averaging in parts[0].items()
    }


def _means(
    axle_position: np.ndarray,
    sets: np.ndarray,
    rows: slice,
    distance: np.ndarray,
    integrals: Mapping[Receiver, np.ndarray],
    over_train: Mapping[Receiver, TrainIntegrals],
) -> Means:
    """Return ∫ |u|² dx summed over sets of forces (lines, axles, sets), each alone."""
    on_rows = {receiver: integral[rows] for receiver, integral in integrals.items()}
    over_line = line_means(on_rows, distance, axle_position, sets)
    means = {receiver: {"line": mean} for receiver, mean in over_line.items()}
    if over_train:
        product = force_products(sets)
        for receiver, train in over_train.items():
            means[receiver]["train"] = np.einsum("flm,flm->f", product, train.integral[rows]).real
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
    for receiver, integral in integrals.items():
        pairs = {"line": axle_pairs(integral[rows], distance, axle_position)}
        if over_train:
            pairs["train"] = over_train[receiver].integral[rows]
        means[receiver] = {
            averaging: np.einsum(
                "fpq,fp,fq->f", products(pair, matrices), phase.conj(), phase, optimize=True
            ).real
            for averaging, pair in pairs.items()
        }
    return means
