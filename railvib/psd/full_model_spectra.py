"""Spectra of a case by the full model: a receiver hears many excitation frequencies of a moving train."""

from collections.abc import Mapping

import numpy as np

from railvib import cost
from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import axle_forces
from railvib.parameters.receiver import Receiver
from railvib.psd.excitation import excitation
from railvib.psd.full_model import passage_spectra
from railvib.psd.spectra import Passage, Spectra, assemble
from railvib.transfer.transfer_function import TransferFunction


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
        Highest frequency of excitation that counts, Hz, see `railvib.psd.excitation.highest_excitation`.
    tolerance
        Relative error allowed in the excitation.
    """
    train, speed, f = passage.train, passage.speed, passage.frequency
    force = np.abs(axle_forces(train, rail, f, passage.phase)) ** 2
    with cost.stage("excitation"):
        excited = excitation(train, rail, passage.unevenness, speed, highest, tolerance, passage.refinement)
    psd = passage_spectra(receivers, excited, train.length, speed, f)
    displacement = {receiver: {"line": values} for receiver, values in psd.items()}
    return assemble("full", passage, force, displacement, quasi_static)
