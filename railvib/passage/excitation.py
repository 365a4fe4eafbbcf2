"""Forces of the axles per harmonic of the unevenness, without their phases.

    q_l(β) = P_l(βv) e^{−iβα_l} √S_w(β)

as in `railvib.psd.excitation`, here at the harmonics of a passage.
"""

import numpy as np

from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import AxleEquations, axle_phases
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train
from railvib.psd.excitation import LOWEST_HZ


def moving_excitation(
    train: Train, rail: Receptances, unevenness: Unevenness, speed: float, wavenumber: np.ndarray
) -> np.ndarray:
    """Return q_l by the full model, N/√(rad/m), complex (sets, n, axles).

    The first set is that of the rails' unevenness; each wheelset that is out of round adds one.

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
    equations = AxleEquations(train, rail, frequency)
    inside = unevenness.psd(wavenumber) > 0.0
    uneven = unevenness.uncut.psd(frequency * 2.0 * np.pi / speed) * inside
    force = equations.forces(slice(None), (phase * np.sqrt(uneven)[:, None])[..., None])
    return _by_sets(force, phase, _wheel_forces(equations, train, wavenumber))


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
        Whether each axle has its own unevenness (Eq. 28); else all axles share one set (Eq. 23). Each
        wheelset that is out of round adds a set.
    """
    frequency = wavenumber * speed / (2.0 * np.pi)
    phase = axle_phases(train, frequency, speed)
    equations = AxleEquations(train, rail, frequency)
    size = np.sqrt(unevenness.psd(wavenumber))[:, None, None]
    if uncorrelated:
        force = equations.matrices(slice(None)) * size
    else:
        force = equations.forces(slice(None), phase[..., None] * size)
    return _by_sets(force, phase, _wheel_forces(equations, train, wavenumber))


def _wheel_forces(equations: AxleEquations, train: Train, wavenumber: np.ndarray) -> np.ndarray | None:
    """Return the forces by the roughness of each wheelset that is out of round, (n, axles, sets)."""
    if not train.has_rough_wheels:
        return None
    rough = [(axle, spectrum) for axle, spectrum in enumerate(train.wheel_spectra) if spectrum is not None]
    size = np.stack([np.sqrt(spectrum.psd(wavenumber)) for _axle, spectrum in rough], axis=1)
    matrices = equations.matrices(slice(None))[:, :, [axle for axle, _spectrum in rough]]
    return np.asarray(matrices * size[:, None, :])


def _by_sets(force: np.ndarray, phase: np.ndarray, wheels: np.ndarray | None) -> np.ndarray:
    """Return forces (n, axles, sets) without their phases, (sets, n, axles)."""
    if wheels is not None:
        force = np.concatenate([force, wheels], axis=2)
    return np.ascontiguousarray(np.moveaxis(force * phase.conj()[..., None], 2, 0))
