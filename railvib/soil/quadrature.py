"""Direct quadrature of the ground's compliance: the slow judge of the closed forms, and their fallback.

The Fourier integral over the lateral wavenumber γ runs along the real axis to beyond every pole and branch
point, by adaptive Gauss panels, and from there at 45° into the complex plane, where e^{iγy} decays and which
keeps clear of the evanescent modes of the layers; so nothing is truncated and no rational fit is involved.
Q33 is even in γ, hence integrals from 0.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from railvib.parameters.ground import Ground
from railvib.soil._kernels.layers import complex_flexibilities, surface_flexibilities

_COARSE_NODE, _COARSE_WEIGHT = legendre.leggauss(10)
_FINE_NODE, _FINE_WEIGHT = legendre.leggauss(21)
_MOST_ROUNDS = 60
_MOST_PANELS = 20_000


def adaptive_integral(
    integrand: Callable[[np.ndarray], np.ndarray],
    edges: npt.ArrayLike,
    tolerance: float,
    scale: npt.ArrayLike = 0.0,
) -> np.ndarray:
    """Return ∫ f dt over the panels between `edges`, halving every panel whose error is not yet small.

    Parameters
    ----------
    integrand
        Takes real t (n,) and returns f (n, m), real or complex.
    edges
        Ascending panel edges.
    tolerance
        Error allowed in each component, relative to the larger of |integral| and `scale`.
    scale
        Size below which an error counts as absolute, one value or (m,).

    Returns
    -------
    ndarray, shape (m,)

    Raises
    ------
    ArithmeticError
        If the panels do not converge.
    """
    low = np.asarray(edges, float)[:-1]
    high = np.asarray(edges, float)[1:]
    whole = np.abs(high - low).sum()
    done = 0.0
    for _ in range(_MOST_ROUNDS):
        half = 0.5 * (high - low)[:, None]
        middle = 0.5 * (high + low)[:, None]
        t_coarse = (middle + half * _COARSE_NODE).ravel()
        t_fine = (middle + half * _FINE_NODE).ravel()
        values = integrand(np.concatenate([t_coarse, t_fine]))
        coarse = (
            values[: t_coarse.size].reshape(low.size, 10, -1) * (half * _COARSE_WEIGHT)[:, :, None]
        ).sum(axis=1)
        fine = (values[t_coarse.size :].reshape(low.size, 21, -1) * (half * _FINE_WEIGHT)[:, :, None]).sum(
            axis=1
        )
        total = done + fine.sum(axis=0)
        allowed = tolerance * np.maximum(np.abs(total), scale)
        # The coarse rule's error bounds the fine one's by far, so panels share the allowance by their width,
        # not below 1e-3.
        share = np.maximum(np.abs(high - low) / whole, 1e-3)
        bad = (np.abs(fine - coarse) > allowed * share[:, None]).any(axis=1)
        done = done + fine[~bad].sum(axis=0)
        if not bad.any():
            return np.asarray(done)
        if bad.sum() > _MOST_PANELS:
            break
        middle = 0.5 * (low + high)[bad]
        low, high = np.concatenate([low[bad], middle]), np.concatenate([middle, high[bad]])
    raise ArithmeticError(f"quadrature did not reach the relative error {tolerance:g}")


def strip_compliance_by_quadrature(
    ground: Ground,
    half_width: float,
    wavenumber: float,
    offsets: npt.ArrayLike,
    frequency: float,
    tolerance: float = 1e-9,
) -> np.ndarray:
    """Return C(β, y, ω) of the strip load by direct quadrature over γ.

    Parameters
    ----------
    ground
        The layered ground.
    half_width
        Half the contact width b, m.
    wavenumber
        β along the track, rad/m.
    offsets
        Distances y from the centre line, (m,), m.
    frequency
        Frequency, Hz; positive.
    tolerance
        Relative error allowed at each offset, above 1e-12 of the value on the centre line.

    Returns
    -------
    ndarray of complex, shape (m,)
        Displacement at y per unit force per length of track, m²/N.

    Notes
    -----
    docs/conventions.md: C = (1/2π) ∫ Q33(√(β²+γ²)) sin(γb)/(γb) e^{iγy} dγ.
    """
    y = np.abs(np.atleast_1d(np.asarray(offsets, float)))
    b = half_width
    beta = abs(wavenumber)
    omega = 2.0 * np.pi * frequency
    stack = ground.stack()
    rigid = ground.base == "rigid"
    longest = max(float(y.max()) + b, b)
    turn, edges = _panels(ground, beta, omega, longest)

    def along(gamma: np.ndarray) -> np.ndarray:
        q = surface_flexibilities(np.sqrt(beta**2 + gamma**2), omega, stack, rigid)
        return np.asarray((q * np.sinc(gamma * b / np.pi))[:, None] * np.cos(gamma[:, None] * y) / np.pi)

    def beyond(t: np.ndarray) -> np.ndarray:
        # γ = turn + (1 + i) τ with τ = (1 − t)/t. sin(γb) cos(γy)/(γb) = Σ sin(γ(b ± y))/(2γb): each sine
        # splits into e^{+iγ…}, taken on this path, and e^{−iγ…}, taken on its mirror image below the real
        # axis.
        gamma = turn + (1.0 + 1.0j) * (1.0 - t) / t
        upper = complex_flexibilities(np.sqrt(beta**2 + gamma**2), omega, stack, rigid)
        lower = complex_flexibilities(np.sqrt(beta**2 + gamma.conj() ** 2), omega, stack, rigid)
        upper *= (1.0 + 1.0j) / (4.0j * np.pi * b * gamma * t**2)
        lower *= (1.0 - 1.0j) / (4.0j * np.pi * b * gamma.conj() * t**2)
        out = np.zeros((t.size, y.size), complex)
        for i, offset in enumerate(y):
            for length in (b + offset, b - offset):
                wave = np.exp(1j * gamma * abs(length))
                out[:, i] += np.sign(length) * (upper * wave - lower * wave.conj())
        return out

    centre = np.argmin(y)
    floor = np.where(
        np.arange(y.size) == centre, 0.0, 1e-12 * abs(adaptive_integral(along, edges, 1e-3, 1e-300)[centre])
    )
    real_axis = adaptive_integral(along, edges, tolerance, floor)
    floor = np.maximum(np.abs(real_axis), floor)
    return np.asarray(real_axis + adaptive_integral(beyond, np.linspace(1e-9, 1.0, 9), tolerance, floor))


def strip_mean_by_quadrature(
    ground: Ground, half_width: float, wavenumber: float, frequency: float, tolerance: float = 1e-9
) -> complex:
    """Return the mean of C(β, y, ω) over the strip by direct quadrature over γ, m²/N.

    Parameters
    ----------
    ground, half_width, wavenumber, frequency
        As in `strip_compliance_by_quadrature`.
    tolerance
        Relative error allowed.

    Notes
    -----
    (1/2π) ∫ Q33(√(β²+γ²)) [sin(γb)/(γb)]² dγ.
    """
    b = half_width
    beta = abs(wavenumber)
    omega = 2.0 * np.pi * frequency
    stack = ground.stack()
    rigid = ground.base == "rigid"
    turn, edges = _panels(ground, beta, omega, 2.0 * b)

    def along(gamma: np.ndarray) -> np.ndarray:
        q = surface_flexibilities(np.sqrt(beta**2 + gamma**2), omega, stack, rigid)
        return np.asarray((q * np.sinc(gamma * b / np.pi) ** 2)[:, None] / np.pi)

    def beyond(t: np.ndarray) -> np.ndarray:
        # As for the strip, with [sin(γb)/(γb)]² = (2 − e^{2iγb} − e^{−2iγb})/(4γ²b²).
        gamma = turn + (1.0 + 1.0j) * (1.0 - t) / t
        wave = 1.0 - np.exp(2.0j * gamma * b)
        upper = complex_flexibilities(np.sqrt(beta**2 + gamma**2), omega, stack, rigid)
        lower = complex_flexibilities(np.sqrt(beta**2 + gamma.conj() ** 2), omega, stack, rigid)
        upper *= (1.0 + 1.0j) * wave / gamma**2
        lower *= (1.0 - 1.0j) * wave.conj() / gamma.conj() ** 2
        return np.asarray(((upper + lower) / (4.0 * np.pi * b**2 * t**2))[:, None])

    real_axis = adaptive_integral(along, edges, tolerance)
    tail = adaptive_integral(beyond, np.linspace(1e-9, 1.0, 9), tolerance, np.abs(real_axis))
    return complex(real_axis[0] + tail[0])


def _panels(ground: Ground, beta: float, omega: float, longest: float) -> tuple[float, np.ndarray]:
    """Return where the path leaves the real axis, rad/m, and the first edges of panels up to there.

    Parameters
    ----------
    ground, beta, omega
        The ground, β in rad/m and ω in rad/s.
    longest
        Distance whose phase is the fastest over γ, m.
    """
    slowest = omega / ground.slowest_speed
    # Past the propagating modes, and past the evanescent ones of stiff layers on soft ones, which lie within
    # a few 1/h.
    thinnest = min(
        (layer.thickness for layer in ground.layers if layer.thickness is not None), default=np.inf
    )
    turn = max(1.5 * np.sqrt(max(slowest**2 - beta**2, 0.0)), 0.5 * slowest, 0.5 * beta, 3.0 / thinnest)
    marks = np.concatenate([omega / np.array(list(ground.wave_speeds())), [0.0]])
    breaks = np.sqrt(np.maximum(marks**2 - beta**2, 0.0))
    panels = max(int(turn * longest / 6.0), 4)
    edges = np.unique(np.concatenate([breaks[breaks < turn], np.linspace(0.0, turn, panels + 1)]))
    return turn, edges
