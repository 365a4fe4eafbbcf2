"""Surface waves of the ground: its Rayleigh modes."""

import numpy as np

from railvib.errors import InputError
from railvib.parameters.ground import Ground
from railvib.soil.flexibility import surface_flexibility
from railvib.soil.rational_fit import fit_flexibility

_MOST_STEPS = 60


def surface_wave_speeds(ground: Ground, frequency: float) -> np.ndarray:
    """Return the phase speeds of the Rayleigh modes at one frequency, ascending: the fundamental mode first.

    Parameters
    ----------
    ground
        The layered ground. Nearly elastic ground (loss factor 1e-3 or less) gives the classical dispersion
        curves; damping shifts a mode by about the square of its loss factor, and strongly damped modes are
        left out.
    frequency
        Frequency, Hz, positive.

    Returns
    -------
    ndarray
        m/s; empty where no mode propagates without leaking, as under a stiff crust on softer ground.

    Raises
    ------
    InputError
        If the frequency is not positive.

    Notes
    -----
    A mode is a pole of Q33. The poles of the rational fit near the real axis start a secant search on
    1/Q33 itself, which drops those that stand for a branch cut.
    """
    from scipy.optimize import newton  # slow to import, and no worker needs it

    if not frequency > 0.0:
        raise InputError(f"frequency = {frequency} Hz: surface waves have a positive frequency")
    omega = 2.0 * np.pi * frequency
    stack = ground.stack()
    rigid = ground.base == "rigid"
    start = np.sqrt(fit_flexibility(ground, frequency, 1e-9).pole)
    # A mode decays by η/2 times the ratio of its phase speed to its group speed, which may reach a few.
    limit = min(3.0 * max(layer.loss_factor for layer in ground.layers), 0.5) + 1e-6
    fastest = (
        max(layer.shear_speed for layer in ground.layers[-1:])
        if not rigid
        else 20.0 * max(ground.wave_speeds())
    )
    near = start[
        (np.abs(start.imag) < (limit + 0.02) * start.real)
        & (start.real < 1.05 * omega / ground.slowest_speed)
        & (start.real > 0.95 * omega / fastest)
    ]

    def inverse(k: complex) -> complex:
        try:
            return 1.0 / complex(surface_flexibility(k, omega, stack, rigid))
        except ZeroDivisionError:  # exactly on the pole
            return 0j

    found: list[complex] = []
    for candidate in near:
        first = complex(candidate.real, -abs(candidate.imag))
        with np.errstate(invalid="ignore", over="ignore"):  # of a search that runs away
            k, search = newton(
                inverse,
                first,
                x1=first * (1.0 + 1e-6),
                tol=1e-13 * abs(first),
                maxiter=_MOST_STEPS,
                full_output=True,
                disp=False,
            )
        close = abs(k - first) < 0.1 * abs(first)
        decays = abs(k.imag) <= limit * k.real
        slower = rigid or k.real > omega / fastest
        new = all(abs(k - each) > 1e-7 * abs(each) for each in found)
        if search.converged and close and decays and slower and new:
            found.append(k)
    return np.sort(omega / np.array([each.real for each in found]))
