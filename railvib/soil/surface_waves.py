"""Surface waves of the ground: its Rayleigh modes."""

from collections.abc import Callable

import numpy as np

from railvib.errors import InputError
from railvib.numerics.analytic_zeros import zeros
from railvib.parameters.ground import Ground
from railvib.soil._kernels.rayleigh import log_secular

_MOST_DECAY = 0.5
"""Largest |Im k|/Re k of a mode that counts: it falls to e^−π over a wavelength."""
_SLOWEST = 0.5
"""Share of the layers' slowest Rayleigh speed below which no mode is: a heavy crust slows waves down, not
that much.
"""
_FASTEST = 20.0
"""Multiple of the fastest wave's speed up to which modes over rigid bedrock are sought."""
_NEAREST = 1e-6
"""Where the region begins, in ζ: a mode closer than 1e-12 to the base's shear speed is not told from it."""
_LIMITS = (1.05, 1.2, 1.6, np.inf)
"""Multiples of the slowest layer's Rayleigh speed up to which the slowest mode is sought, in turn."""
_MARGINS = (0.1, 0.093, 0.107)
"""Distance of the region's edge from what it must hold, in turn until no zero lies on the edge."""


def surface_wave_speeds(ground: Ground, frequency: float) -> np.ndarray:
    """Return the phase speeds of all Rayleigh modes at one frequency, ascending.

    Parameters
    ----------
    ground
        The layered ground. Without damping its modes are the classical dispersion curves; damping shifts a
        mode by about the square of its loss factor.
    frequency
        Frequency, Hz, positive.

    Returns
    -------
    ndarray
        m/s. All proper modes: slower than the base's shear waves, and decaying with depth in a half-space.
        Modes that fall by more than e^−π over a wavelength are left out. Empty where there is none, as under
        a stiff crust on softer ground. Modes of a soft layer deep below are there too, whether or not they
        are felt at the surface; over rigid bedrock those faster than 20 times the fastest wave are not.

    Raises
    ------
    InputError
        If the frequency is not positive.

    Notes
    -----
    Zeros of the Rayleigh secular function, as many as its phase counts around a region (argument principle).
    The region is a rectangle of ζ, with k = k_s cosh ζ, so that the half-space's
    vertical wavenumber s = k_s sinh ζ has no branch point there; over rigid bedrock k is proportional to e^ζ.
    """
    return _speeds(ground, frequency, np.inf)


def slowest_surface_wave_speed(ground: Ground, frequency: float) -> float:
    """Return the phase speed of the slowest Rayleigh mode at one frequency, m/s; infinite without one.

    Deep soft ground has a thousand modes: only those below a speed are sought, which is raised until one is
    there. Arguments and errors are those of `surface_wave_speeds`.
    """
    slowest = min(layer.rayleigh_speed for layer in ground.layers)
    for limit in _LIMITS:
        try:
            speeds = _speeds(ground, frequency, limit * slowest)
        except ArithmeticError:  # a mode lies at the limit itself
            if limit == np.inf:
                raise
            continue
        if speeds.size:
            return float(speeds[0])
    return float(np.inf)


def _speeds(ground: Ground, frequency: float, limit: float) -> np.ndarray:
    """Return the phase speeds of the modes below a limit, ascending, m/s."""
    if not (frequency > 0.0 and np.isfinite(frequency)):
        raise InputError(f"frequency = {frequency} Hz: surface waves have a positive frequency")
    omega = 2.0 * np.pi * frequency
    most_decay = _most_decay(ground)
    k = _wavenumbers(ground, omega, most_decay, limit)
    fastest = np.inf if ground.base == "rigid" else ground.layers[-1].shear_speed
    counts = (np.abs(k.imag) <= most_decay * k.real) & (k.real > omega / min(fastest, limit))
    return np.sort(omega / k.real[counts])


def _most_decay(ground: Ground) -> float:
    """Return an upper bound of |Im k|/Re k, that of modes which damping alone makes decay.

    It is η/2 times the ratio of phase to group speed, which is at most about (phase speed/slowest shear
    speed)².
    """
    speeds = [layer.shear_speed for layer in ground.layers]
    fastest = _FASTEST * max(ground.wave_speeds()) if ground.base == "rigid" else speeds[-1]
    damping = max(layer.loss_factor for layer in ground.layers)
    return min(_MOST_DECAY, 0.75 * damping * (fastest / min(speeds)) ** 2 + 1.5 * damping + 1e-6)


def _wavenumbers(ground: Ground, omega: float, most_decay: float, limit: float) -> np.ndarray:
    """Return the wavenumbers of the modes in a region that holds all up to a decay and a speed, rad/m."""
    slowest = omega / (_SLOWEST * min(layer.rayleigh_speed for layer in ground.layers))
    stack = ground.stack()
    if ground.base == "rigid":
        fastest = omega / (_FASTEST * max(ground.wave_speeds()))
        nearest = max(0.0, float(np.log(omega / limit / fastest))) if limit < np.inf else 0.0
        farthest = float(np.log(slowest / fastest))
        deepest = float(np.arctan(most_decay))

        def wavenumber(zeta: np.ndarray) -> np.ndarray:
            return np.asarray(fastest * np.exp(zeta))

        def log_function(zeta: np.ndarray) -> np.ndarray:
            k = wavenumber(zeta)
            return np.asarray(log_secular(k, k, k, omega, stack, True))

    else:
        base = ground.layers[-1]
        ks = omega / base.shear_speed / np.sqrt(1.0 + 1j * base.loss_factor)
        e = (base.shear_speed / base.dilatational_speed) ** 2
        nearest = max(_NEAREST, float(np.arccosh(max(base.shear_speed / limit, 1.0))))
        farthest = float(np.arccosh(slowest * base.shear_speed / omega))
        # Where the lines of Re k = ω/c_s and of the largest decay meet.
        deepest = float(np.arccos(2.0 / (most_decay + np.sqrt(most_decay**2 + 4.0))))

        def wavenumber(zeta: np.ndarray) -> np.ndarray:
            return np.asarray(ks * np.cosh(zeta))

        def log_function(zeta: np.ndarray) -> np.ndarray:
            cosh = np.cosh(zeta)
            p, s = ks * np.sqrt(cosh**2 - e), ks * np.sinh(zeta)
            return np.asarray(log_secular(ks * cosh, p, s, omega, stack, False))

    return wavenumber(_zeros_inside(log_function, nearest, farthest, deepest))


def _zeros_inside(
    log_function: Callable[[np.ndarray], np.ndarray], left: float, right: float, depth: float
) -> np.ndarray:
    """Return the zeros between two limits, from a margin above the real axis to one below a depth."""
    for margin in _MARGINS:
        try:
            return zeros(log_function, complex(left, -depth - margin), complex(right, margin))
        except ArithmeticError as error:
            failure = error
    raise failure
