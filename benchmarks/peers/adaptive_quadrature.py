"""The ground's compliance by adaptive quadrature over γ, all wavenumbers and panels together.

The path is that of `railvib.soil.quadrature`: along the real axis past the propagating waves, then at 45°
into the complex plane, where e^{iγy} decays. That module integrates one wavenumber at a time, as a
judge; this one halves the panels of all wavenumbers in the same passes, so that NumPy works on long arrays.
"""

from collections.abc import Callable

import numpy as np
from scipy.special import roots_legendre

from railvib.parameters.ground import Ground
from railvib.soil._kernels.layers import surface_flexibilities

_COARSE_NODE, _COARSE_WEIGHT = roots_legendre(6)
_FINE_NODE, _FINE_WEIGHT = roots_legendre(12)
_MOST_ROUNDS = 40
_PANELS_BEYOND = 4
_PHASE = 12.0
"""Phase of a panel at the farthest offset before it is halved, rad."""

Integrand = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Takes β and t, both (n,), and returns values (n, offsets)."""


def compliances(
    ground: Ground,
    half_width: float,
    beta: np.ndarray,
    offsets: np.ndarray,
    frequency: float,
    tolerance: float,
) -> np.ndarray:
    """Return C(β, y) of the strip load, (β, offsets), m²/N.

    Parameters
    ----------
    ground
        The layered ground.
    half_width
        Half the contact width b, m.
    beta
        Wavenumbers along the track, (n,), rad/m, not negative.
    offsets
        Distances from the centre line, (m,), m; the first is 0.
    frequency
        Frequency, Hz.
    tolerance
        Error allowed relative to |C(β, 0)|. The difference of two rules stands for it, which is far larger.
    """
    omega = 2.0 * np.pi * frequency
    b = half_width
    slowest = omega / ground.slowest_speed
    thinnest = min(
        (layer.thickness for layer in ground.layers if layer.thickness is not None), default=np.inf
    )
    turn = np.maximum(
        np.maximum(1.5 * np.sqrt(np.maximum(slowest**2 - beta**2, 0.0)), 0.5 * slowest),
        np.maximum(0.5 * beta, 3.0 / thinnest),
    )
    stack, rigid = ground.stack(), ground.base == "rigid"

    def flexibility(beta: np.ndarray, gamma: np.ndarray) -> np.ndarray:
        return np.asarray(surface_flexibilities(np.sqrt(beta**2 + gamma**2), omega, stack, rigid))

    def along(row: np.ndarray, gamma: np.ndarray) -> np.ndarray:
        q = flexibility(beta[row], gamma) * np.sinc(gamma * (b / np.pi))
        return np.asarray(q[:, None] * np.cos(gamma[:, None] * offsets) / np.pi)

    def beyond(row: np.ndarray, t: np.ndarray) -> np.ndarray:
        gamma = turn[row] + (1.0 + 1.0j) * (1.0 - t) / t
        upper = flexibility(beta[row], gamma) * (1.0 + 1.0j) / (4.0j * np.pi * b * gamma * t**2)
        below = gamma.conj()
        lower = flexibility(beta[row], below) * (1.0 - 1.0j) / (4.0j * np.pi * b * below * t**2)
        out = np.zeros((t.size, offsets.size), complex)
        for length in (b + offsets, b - offsets):
            wave = np.exp(1j * gamma[:, None] * np.abs(length))
            out += np.sign(length) * (upper[:, None] * wave - lower[:, None] * wave.conj())
        return out

    panels = np.maximum(np.ceil(turn * (offsets.max() + b) / _PHASE).astype(int), 4)
    row = np.repeat(np.arange(beta.size), panels)
    place = np.arange(row.size) - np.repeat(np.cumsum(panels) - panels, panels)
    width = (turn / panels)[row]
    total = np.zeros((beta.size, offsets.size), complex)
    _add(along, row, place * width, (place + 1) * width, tolerance, total)
    row = np.repeat(np.arange(beta.size), _PANELS_BEYOND)
    low = np.tile(np.linspace(1e-9, 1.0, _PANELS_BEYOND + 1)[:-1], beta.size)
    _add(beyond, row, low, low + 1.0 / _PANELS_BEYOND, tolerance, total)
    return total


def _add(
    integrand: Integrand,
    row: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    tolerance: float,
    total: np.ndarray,
) -> None:
    """Add integrals over panels [low, high] to the totals of their rows, halving panels with large errors."""
    share = 1.0 / np.bincount(row, minlength=total.shape[0])[row]
    for _ in range(_MOST_ROUNDS):
        middle, half = 0.5 * (high + low), 0.5 * (high - low)
        fine = _sums(integrand, row, middle, half, _FINE_NODE, _FINE_WEIGHT)
        coarse = _sums(integrand, row, middle, half, _COARSE_NODE, _COARSE_WEIGHT)
        # The size at y = 0 includes the panels that are not accepted yet.
        size = np.abs(total[:, 0] + _by_row(row, fine, total.shape)[:, 0])
        # Errors are taken to add up like random numbers, as the fine rule's are far below the coarse one's.
        bad = (np.abs(fine - coarse) > (tolerance * size[row] * np.sqrt(share))[:, None]).any(axis=1)
        total += _by_row(row[~bad], fine[~bad], total.shape)
        if not bad.any():
            return
        row, share = np.tile(row[bad], 2), np.tile(share[bad], 2)
        low, high = np.concatenate([low[bad], middle[bad]]), np.concatenate([middle[bad], high[bad]])
    raise ArithmeticError(f"quadrature did not reach the relative error {tolerance:g}")


def _sums(
    integrand: Integrand,
    row: np.ndarray,
    middle: np.ndarray,
    half: np.ndarray,
    node: np.ndarray,
    weight: np.ndarray,
) -> np.ndarray:
    """Return a Gauss rule's sums over panels, (panels, offsets)."""
    t = (middle[:, None] + half[:, None] * node).ravel()
    values = integrand(np.repeat(row, node.size), t).reshape(row.size, node.size, -1)
    return np.asarray(np.einsum("pno,n->po", values, weight) * half[:, None])


def _by_row(row: np.ndarray, value: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return the sums of panels by row."""
    out = np.zeros(shape, complex)
    np.add.at(out, row, value)
    return out
