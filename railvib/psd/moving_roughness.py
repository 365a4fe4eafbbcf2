"""The moving-roughness approach: the train stands, and the roughness is pulled through under its wheels.

Averaged over the whole line, the response to forces P_l needs the transfer function only through

    M(d, f) = (1/π) ∫₀^∞ |H̃(β, f)|² cos(βd) dβ

at the distances d between axles (Parseval). M does not depend on speed: it is computed once for every speed
and every form of the approach.
"""

from collections.abc import Mapping

import numpy as np

from railvib.parameters.receiver import Receiver
from railvib.psd._kernels.averages import add_force_products


def axle_spans(axle_position: np.ndarray) -> np.ndarray:
    """Return the distinct distances between axles at α, ascending from 0, m."""
    return np.unique(np.round(np.abs(axle_position[:, None] - axle_position[None, :]), 9))


def axle_pairs(integral: np.ndarray, distance: np.ndarray, axle_position: np.ndarray) -> np.ndarray:
    """Return M(α_l − α_m, f) for every two axles, (lines, axles, axles), m³/N².

    Parameters
    ----------
    integral, distance
        M(d, f), m³/N², (lines, distances), and d ≥ 0, m, ascending.
    axle_position
        α, m, (axles,).
    """
    return np.asarray(integral[:, _columns(distance, axle_position)])


def _columns(distance: np.ndarray, axle_position: np.ndarray) -> np.ndarray:
    """Return the index among ascending distances of that between every two axles, (axles, axles)."""
    between = np.round(np.abs(axle_position[:, None] - axle_position[None, :]), 9)
    return np.asarray(np.searchsorted(distance, between - 1e-8))


def products(pairs: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return ∫ u_p* u_q dx of the displacements by several sets of forces.

    Parameters
    ----------
    pairs
        ∫ H*(x − α_l) H(x − α_m) dx for every two axles, (lines, axles, axles), m³/N²: over the whole line
        from `axle_pairs`, over the train from `railvib.psd.train_average`.
    force
        Forces at the axles, complex (lines, axles, sets), N.

    Returns
    -------
    ndarray of complex, shape (lines, sets, sets)
        Σ_lm P_lp* P_mq times the pair's integral, m³.
    """
    return np.asarray(force.conj().swapaxes(1, 2) @ _responses(pairs, force))


def force_products(force: np.ndarray) -> np.ndarray:
    """Return Σ_s P_ls* P_ms over sets of forces (lines, axles, sets): (lines, axles, axles), N²."""
    return np.asarray(force.conj() @ force.swapaxes(1, 2))


def line_means(
    integrals: Mapping[Receiver, np.ndarray],
    distance: np.ndarray,
    axle_position: np.ndarray,
    force: np.ndarray,
) -> dict[Receiver, np.ndarray]:
    """Return ∫ |u|² dx over the whole line, summed over the displacements by each set of forces alone.

    Parameters
    ----------
    integrals, distance
        M(d, f) of some receivers, m³/N², (lines, distances) each, and d ≥ 0, m, ascending.
    axle_position
        α, m, (axles,).
    force
        Forces at the axles, complex (lines, axles, sets), N.

    Returns
    -------
    dict of ndarray, shape (lines,)
        Σ_s Σ_lm P_ls* P_ms M(α_l − α_m), m³.

    Notes
    -----
    M is real and even, so only the real part of the forces' products counts, summed by distance.
    """
    parts = np.ascontiguousarray(force, complex).view(float)
    product = np.zeros((force.shape[0], distance.size))
    add_force_products(parts, _columns(distance, axle_position), product)
    return {
        receiver: np.asarray(np.einsum("fd,fd->f", integral, product))
        for receiver, integral in integrals.items()
    }


def _responses(pairs: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return Σ_m pairs_lm P_mp, with real arithmetic where the integrals are real."""
    if np.isrealobj(pairs):
        return np.asarray(pairs @ np.ascontiguousarray(force).view(float)).view(complex)
    return np.asarray(pairs @ force)
