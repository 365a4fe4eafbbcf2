"""Spectra of a case by the full model: a receiver hears many excitation frequencies of a moving train."""

from collections.abc import Mapping

import numpy as np

from railvib import cost
from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import AxleEquations, axle_forces
from railvib.parameters.receiver import Receiver
from railvib.psd.excitation import excitation, wheel_excitations
from railvib.psd.full_model import passage_spectra
from railvib.psd.spectra import Passage, Spectra, WheelShare, assemble
from railvib.transfer.transfer_function import TransferFunction

_LINES_AT_ONCE = 128
"""Lines whose matrices of axles are in memory at once."""


def full_model_spectra(
    passage: Passage,
    rail: Receptances,
    quasi_static: Mapping[Receiver, np.ndarray],
    receivers: Mapping[Receiver, TransferFunction],
    highest: float,
    tolerance: float,
) -> Spectra:
    """Predict the spectra of a passage by the full model.

    Parameters
    ----------
    passage
        The train, the unevenness, the speed and the bands.
    rail
        The rail's receptances for loads at the train's speed.
    quasi_static
        The receivers' PSDs of displacement from the axle loads on the lines, m²/Hz, (n,) each.
    receivers
        The receivers' transfer functions, which may be loaded when asked for.
    highest
        Highest frequency of excitation that counts, Hz, see `railvib.transfer.highest_frequencies`.
    tolerance
        Relative error allowed in the excitation.
    """
    train, speed, f = passage.train, passage.speed, passage.frequency
    force = np.abs(axle_forces(train, rail, f, passage.phase)) ** 2
    with cost.stage("excitation"):
        excited = excitation(train, rail, passage.unevenness, speed, highest, tolerance, passage.refinement)
    psd = passage_spectra(receivers, excited, train.length, speed, f)
    displacement = {receiver: {"line": values} for receiver, values in psd.items()}
    wheels = None
    if train.has_rough_wheels:
        with cost.stage("excitation"):
            rough = wheel_excitations(train, rail, speed, highest, tolerance, passage.refinement)
        psd = passage_spectra(receivers, rough, train.length, speed, f)
        from_wheels = {receiver: {"line": values} for receiver, values in psd.items()}
        wheels = WheelShare(_wheel_forces(passage, rail), from_wheels)
    return assemble("full", passage, force, displacement, quasi_static, wheels)


def _wheel_forces(passage: Passage, rail: Receptances) -> np.ndarray:
    """Return one-sided PSDs of the forces by the wheels' roughness, N²/Hz, (lines, axles)."""
    equations = AxleEquations(passage.train, rail, passage.frequency)
    rough = passage.wheel_psd
    force = np.empty(rough.shape)
    for start in range(0, len(force), _LINES_AT_ONCE):
        rows = slice(start, start + _LINES_AT_ONCE)
        force[rows] = np.einsum("lap,lp->la", np.abs(equations.matrices(rows)) ** 2, rough[rows])
    return force
