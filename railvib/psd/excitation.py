"""The excitation of the full model: forces of all axles over the wavenumber of the unevenness.

    q_l(β) = P_l(βv) e^{−iβα_l} √S_w(|β|)

The phases of the forces are taken out, so that the q_l vary slowly. They are held as Legendre series on
panels of β, which are halved until the last terms of the series are small.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from railvib.forces.receptance import Receptances
from railvib.forces.wheel_rail import axle_forces, axle_phases, force_matrices
from railvib.numerics.refinement import Panels, divide, halve
from railvib.numerics.wavenumber_panels import ORDER, TO_POWERS, nodes_between, to_legendre
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.vehicle import Train

_FIRST_PANELS = 16
_MOST_HALVINGS = 10
_TAIL = 3.0
"""Largest size of a series' last terms over the tolerance, relative to the largest amplitude of its panel.

Amplitudes are squared, and those of the axles may cancel: so no line deviates by more than three tolerances
of its neighbours, and no one-third octave by more than one tolerance.
"""
LOWEST_HZ = 0.005
"""Frequency whose forces stand for all below: a free vehicle has no static receptance."""


@dataclass(frozen=True)
class Excitation:
    """q_l(β) for β ≥ 0; at −β it is the conjugate."""

    edge: np.ndarray
    """Edges of the panels, rad/m, ascending from 0, (panels + 1,); there is no excitation beyond the last."""
    series: np.ndarray
    """Legendre series of q_l, N/√(rad/m), complex (axles, panels, order)."""
    axle_position: np.ndarray
    """α, m, (axles,)."""
    wavenumbers: tuple[float, float] = (0.0, np.inf)
    """Lowest and highest β of the unevenness, rad/m; those inside are edges of panels."""

    def amplitude_parts(self, phase: np.ndarray) -> np.ndarray:
        """Return phases (lines, axles) times q_l, summed over axles: (2, 2, lines, terms).

        The first index is for real and imaginary part of the phase, the second for those of q_l, which is in
        powers of x from −1 to 1 over its panels. A = Σ_l phase_l q_l at β and at −β follows from them.
        """
        return np.asarray(np.stack([phase.real, phase.imag])[:, None] @ self._powers)

    @cached_property
    def _powers(self) -> np.ndarray:
        """Real and imaginary part of q_l in powers of x, (2, axles, terms)."""
        terms = (self.series @ TO_POWERS).reshape(self.series.shape[0], -1)
        return np.stack([terms.real, terms.imag])


def excitation(
    train: Train,
    moving: Receptances,
    unevenness: Unevenness,
    speed: float,
    maximum_frequency: float,
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> Excitation:
    """Return the forces of the full model over the wavenumber of the unevenness.

    Parameters
    ----------
    train, unevenness
        The train and the rails' unevenness.
    moving
        The rail's receptances at the train's speed.
    speed
        m/s.
    maximum_frequency
        Highest frequency of excitation, Hz.
    tolerance
        Relative error allowed.
    refinement
        For studies of convergence: number of parts into which the panels that resolve it are divided.
    """
    per_hz = 2.0 * np.pi / speed
    # The amplitudes continue smoothly beyond the wavelengths at which the unevenness is cut off.
    uncut = unevenness.uncut

    def amplitude(beta: np.ndarray) -> np.ndarray:
        frequency = np.maximum(beta / per_hz, LOWEST_HZ)
        phase = axle_phases(train, frequency, speed)
        force = axle_forces(train, moving, frequency, phase)
        return np.asarray(force * phase.conj() * np.sqrt(uncut.psd(frequency * per_hz))[:, None])

    shortest, longest = unevenness.cut_offs
    ends = (2.0 * np.pi / longest, 2.0 * np.pi / shortest if shortest > 0.0 else np.inf)
    return resolve(amplitude, maximum_frequency * per_hz, train.axle_positions, ends, tolerance, refinement)


def wheel_excitations(
    train: Train,
    moving: Receptances,
    speed: float,
    maximum_frequency: float,
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> list[Excitation]:
    """Return the forces of the full model by the roughness of each wheelset alone.

    Parameters
    ----------
    train, moving, speed, maximum_frequency, tolerance, refinement
        As in `excitation`.

    Returns
    -------
    list of Excitation
        One per wheelset that is out of round, q_l(β) e^{iβα_p} = P_l(βv) e^{−iβ(α_l − α_p)} √S_r of roughness
        under the wheels of axle p. The excitations are independent of each other.
    """
    per_hz = 2.0 * np.pi / speed
    spectra = train.wheel_spectra
    excitations: list[Excitation] = []
    for spectrum in dict.fromkeys(each for each in spectra if each is not None):
        shortest, longest = spectrum.cut_offs
        ends = (2.0 * np.pi / longest, 2.0 * np.pi / shortest if shortest > 0.0 else np.inf)
        rough = np.array([axle for axle, each in enumerate(spectra) if each == spectrum])

        def amplitude(
            beta: np.ndarray,
            uncut: Unevenness = spectrum.uncut,
            ends: tuple[float, float] = ends,
            rough: np.ndarray = rough,
        ) -> np.ndarray:
            frequency = np.maximum(beta / per_hz, LOWEST_HZ)
            phase = axle_phases(train, frequency, speed)
            force = force_matrices(train, moving, frequency)[:, :, rough]
            force = force * phase.conj()[:, :, None] * phase[:, None, rough]
            # Beyond the cut-offs nothing counts, so that any smooth continuation will do.
            density = uncut.psd(np.clip(beta, *ends))
            return np.asarray(force * np.sqrt(density)[:, None, None]).reshape(beta.size, -1)

        joint = resolve(
            amplitude, maximum_frequency * per_hz, train.axle_positions, ends, tolerance, refinement
        )
        sets = joint.series.reshape(train.axle_count, rough.size, *joint.series.shape[1:])
        excitations += [
            replace(joint, series=np.ascontiguousarray(sets[:, number])) for number in range(rough.size)
        ]
    return excitations


def resolve(
    amplitude: Callable[[np.ndarray], np.ndarray],
    largest: float,
    axle_position: np.ndarray,
    wavenumbers: tuple[float, float] = (0.0, np.inf),
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> Excitation:
    """Return the excitation of given amplitudes on panels that resolve them.

    Parameters
    ----------
    amplitude
        Returns q_l at wavenumbers β > 0 (n,) in rad/m, complex (n, axles).
    largest
        Largest β, rad/m.
    axle_position, wavenumbers
        As in `Excitation`.
    tolerance
        Relative error allowed.
    refinement
        Number of parts into which the panels that resolve it are divided.
    """
    even = np.linspace(0.0, largest, _FIRST_PANELS + 1)
    cuts = [beta for beta in wavenumbers if 0.0 < beta < largest]

    def evaluate(panels: Panels) -> tuple[np.ndarray, np.ndarray]:
        series = _series(amplitude, panels)
        tail = np.abs(series[..., -2:]).max(axis=(1, 2))
        return series, tail > _TAIL * tolerance * np.abs(series).sum(axis=2).max(axis=1)

    first = Panels.between(np.unique(np.concatenate([even, cuts])))
    parts = list(halve(first, evaluate, _MOST_HALVINGS))
    low = np.concatenate([panels.low for panels, _values in parts])
    order = np.argsort(low)
    edge = np.append(low[order], largest)
    series = np.concatenate([values for _panels, values in parts])[order]
    if refinement > 1:
        edge = divide(edge, refinement)
        series = _series(amplitude, Panels.between(edge))
    return Excitation(edge, np.ascontiguousarray(series.swapaxes(0, 1)), axle_position, wavenumbers)


def _series(amplitude: Callable[[np.ndarray], np.ndarray], panels: Panels) -> np.ndarray:
    """Return the Legendre series of amplitudes on panels, complex (n, axles, order)."""
    value = amplitude(nodes_between(panels.edges).ravel())
    return to_legendre(value.reshape(-1, ORDER, value.shape[1]).swapaxes(1, 2))
