"""Forces of the axles per harmonic of the unevenness, without their phases.

    q_l(β) = P_l(βv) e^{−iβα_l} √S_w(β)

as in `railvib.psd.excitation`, here at the harmonics of a passage.
"""

import numpy as np

from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import AxleEquations, axle_forces, axle_phases
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.psd.excitation import LOWEST_HZ


def moving_excitation(
    train: Train, rail: Receptances, unevenness: Unevenness, speed: float, wavenumber: np.ndarray
) -> np.ndarray:
    """Return q_l by the full model, N/√(rad/m), complex (n, axles).

    Parameters
    ----------
    train, unevenness
        The train, and the rails' unevenness.
    rail
        The rail's receptances at the train's speed.
    speed
        m/s.
    wavenumber
        β, rad/m, (n,).
    """
    frequency = np.maximum(wavenumber * speed / (2.0 * np.pi), LOWEST_HZ)
    phase = axle_phases(train, frequency, speed)
    force = axle_forces(train, rail, frequency, phase)
    inside = unevenness.psd(wavenumber) > 0.0
    uneven = unevenness.uncut.psd(frequency * 2.0 * np.pi / speed) * inside
    return np.asarray(force * phase.conj() * np.sqrt(uneven)[:, None])


def standing_excitation(
    train: Train,
    rail: Receptances,
    unevenness: Unevenness,
    speed: float,
    wavenumber: np.ndarray,
    uncorrelated: bool = False,
) -> np.ndarray:
    """Return q_l of every set of unevenness by moving roughness, N/√(rad/m), complex (sets, n, axles).

    Parameters
    ----------
    train, unevenness, speed, wavenumber
        As for `moving_excitation`.
    rail
        The rail's standing receptances.
    uncorrelated
        Whether each axle has its own unevenness (Eq. 28); else there is one set, that of all axles (Eq. 23).
    """
    frequency = wavenumber * speed / (2.0 * np.pi)
    phase = axle_phases(train, frequency, speed)
    equations = AxleEquations(train, rail, frequency)
    if uncorrelated:
        force = equations.matrices(slice(None)) * phase[:, None, :]
    else:
        force = equations.forces(slice(None), phase[..., None])
    weighted = force * (phase.conj() * np.sqrt(unevenness.psd(wavenumber))[:, None])[..., None]
    return np.ascontiguousarray(np.moveaxis(weighted, 2, 0))
