"""Compliance of the ground under a strip and under a point, for any wavenumber, distance and frequency."""

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from railvib.errors import InputError
from railvib.parameters.ground import Ground
from railvib.soil.quadrature import strip_compliance_by_quadrature
from railvib.soil.rational_fit import RationalFit, fit_flexibility
from railvib.soil.strip import strip_compliance

_FIT_TOLERANCE = 3e-12
"""Tighter than the tables' fits: one value can afford it, and far out C is 1e-6 of what it is at the load."""
_ACCEPTED = 1e-6
_WAVENUMBER_TIMES_DISTANCE = 40.0
_LEAST_LOSS_FACTOR = 1e-5
"""Below it neither fits nor quadrature are sure to resolve the peaks of the waves."""


@lru_cache(maxsize=64)
def _fit(ground: Ground, frequency: float, largest: float) -> RationalFit:
    return fit_flexibility(ground, frequency, _FIT_TOLERANCE, largest=largest)


def _check_positive(name: str, value: np.ndarray, unit: str) -> None:
    if not np.all(np.isfinite(value)) or np.any(value <= 0.0):
        raise InputError(f"{name} = {value[~(value > 0.0)].ravel()[:1]} {unit}: must be positive and finite")


def line_compliance(
    ground: Ground,
    half_width: float,
    wavenumber: npt.ArrayLike,
    offset: npt.ArrayLike,
    frequency: npt.ArrayLike,
) -> np.ndarray:
    """Return the ground's displacement beside a strip load that is harmonic along the track.

    Parameters
    ----------
    ground
        The layered ground.
    half_width
        Half the width b over which the load is uniform, m.
    wavenumber
        β along the track, rad/m.
    offset
        Distance y from the centre line, m; even.
    frequency
        Frequency, Hz, positive. The three broadcast.

    Returns
    -------
    ndarray of complex
        C(β, y, ω): displacement at y per unit force per length of track, m²/N.

    Raises
    ------
    InputError
        If the width or a frequency is not positive, or a layer has next to no damping.

    Notes
    -----
    See docs/conventions.md; the poles of a rational fit of Q33, and direct quadrature where it fails. The
    last fits are remembered. Within millimetres of the strip's edge the error may reach 1e-5 of the value.
    """
    beta, y, f = np.broadcast_arrays(
        np.asarray(wavenumber, float), np.asarray(offset, float), np.asarray(frequency, float)
    )
    _check_positive("half_width", np.asarray(half_width, float).reshape(1), "m")
    _check_positive("frequency", f.ravel(), "Hz")
    ground.require_damping(_LEAST_LOSS_FACTOR)
    out = np.empty(beta.shape, complex)
    for value in np.unique(f):
        fit = _fit(ground, float(value), 0.0)
        for distance in np.unique(np.abs(y[f == value])):
            part = (f == value) & (np.abs(y) == distance)
            if fit.error <= _ACCEPTED:
                out[part] = strip_compliance(fit, np.abs(beta[part]), half_width, np.array([distance]))[0]
            else:
                out[part] = [
                    strip_compliance_by_quadrature(ground, half_width, b, [distance], float(value))[0]
                    for b in beta[part]
                ]
    return out[()]


def ground_green_function(ground: Ground, distance: npt.ArrayLike, frequency: npt.ArrayLike) -> np.ndarray:
    """Return the vertical surface displacement beside a vertical point load on the surface.

    Parameters
    ----------
    ground
        The layered ground.
    distance
        Distance r from the load, m, positive.
    frequency
        Frequency, Hz, positive. Both broadcast.

    Returns
    -------
    ndarray of complex
        u_z(r) per unit force, m/N.

    Raises
    ------
    InputError
        If a distance or a frequency is not positive, or a layer has next to no damping.

    Notes
    -----
    (1/2π) ∫ Q33 J0(ρr) ρ dρ = Σ_j a_j K0(√(−z_j) r)/(2π).
    """
    from scipy.special import kv  # slow to import, and not needed by a run

    r, f = np.broadcast_arrays(np.asarray(distance, float), np.asarray(frequency, float))
    _check_positive("distance", r.ravel(), "m")
    _check_positive("frequency", f.ravel(), "Hz")
    ground.require_damping(_LEAST_LOSS_FACTOR)
    out = np.empty(r.shape, complex)
    for value in np.unique(f):
        part = f == value
        fit = _fit(ground, float(value), _WAVENUMBER_TIMES_DISTANCE / float(r[part].min()))
        if fit.error > _ACCEPTED:
            raise ArithmeticError(
                f"the ground's flexibility at {value:g} Hz was fitted to {fit.error:.1e} only"
            )
        out[part] = kv(0, np.sqrt(-fit.pole) * r[part][:, None]) @ fit.residue / (2.0 * np.pi)
    return out[()]
