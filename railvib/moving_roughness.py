"""The moving-roughness approach: the train stands, the roughness is pulled through under its wheels.

Averaged over the whole line, the response to forces P_l needs the transfer function only through

    M(d, f) = (1/π) ∫₀^∞ |H̃(β, f)|² cos(βd) dβ

at the distances d between axles (Parseval): independent of speed, and computed once for every speed and both
forms of the approach.
"""

from dataclasses import dataclass, field

import numba
import numpy as np
import numpy.typing as npt

from railvib import blocks, cost
from railvib.panels import ORDER, fourier_integrals
from railvib.transfer import TransferFunction


@dataclass(frozen=True)
class LineIntegrals:
    """M(d, f) of one receiver: what the response averaged over the line needs of track and ground."""

    frequency: np.ndarray = field(
        metadata={"dims": ("frequency",), "unit": "Hz", "description": "narrow-band lines"}
    )
    distance: np.ndarray = field(
        metadata={"dims": ("distance",), "unit": "m", "description": "distance between axles"}
    )
    integral: np.ndarray = field(
        metadata={
            "dims": ("frequency", "distance"),
            "unit": "m3/N2",
            "description": "line integral of the squared response",
        }
    )


def line_integrals(
    receiver: TransferFunction, distances: npt.ArrayLike, frequency: npt.ArrayLike
) -> LineIntegrals:
    """Return M(d, f) at some distances and frequencies.

    Parameters
    ----------
    receiver
        The receiver's tabulated transfer function.
    distances
        Distances between axles, m; the integral is even in them, and each counts once.
    frequency
        Frequencies, Hz, (n,), inside the tables.
    """
    f = np.asarray(frequency, float)
    d = np.unique(np.abs(np.asarray(distances, float)))
    integral = np.empty((f.size, d.size))
    which = blocks.assigned(f, receiver.blocks)
    with cost.stage("line integrals") as spent:
        for block in np.unique(which):
            table = receiver.blocks[int(block)]
            here = which == block
            _beta, transfer = receiver.at(int(block), f[here])
            squared = (np.abs(transfer) ** 2).reshape(transfer.shape[0], -1, ORDER)
            integral[here] = _cosine_integrals(table.nodes.panel_edges(f[here]), squared, d)
            spent.evaluations += transfer.size
            spent.kernel_calls += 1
    return LineIntegrals(f, d, integral / np.pi)


@numba.njit(cache=True, error_model="numpy")
def _cosine_integrals(edge, squared, distance):
    """Return ∫ |H̃|² cos(βd) dβ, (lines, distances); panels with nothing in them are passed over."""
    out = np.zeros((edge.shape[0], 1, distance.shape[0]))
    sine = np.zeros((1, distance.shape[0]))
    for i in range(edge.shape[0]):
        half = 0.5 * (edge[i, 1:] - edge[i, :-1])
        centre = 0.5 * (edge[i, 1:] + edge[i, :-1])
        size = np.empty(half.shape[0])
        for p in range(half.shape[0]):
            size[p] = half[p] * squared[i, p].max()
        kept = np.flatnonzero(size > 1e-14 * size.sum())
        fourier_integrals(
            centre[kept], half[kept], squared[i][kept].reshape(1, kept.size, ORDER), distance, out[i], sine
        )
    return out[:, 0]


def axle_pairs(integrals: LineIntegrals, axle_position: np.ndarray) -> np.ndarray:
    """Return M(α_l − α_m, f) for every two axles, (lines, axles, axles), m³/N²."""
    column = np.searchsorted(
        integrals.distance, np.round(np.abs(axle_position[:, None] - axle_position[None, :]), 9) - 1e-8
    )
    return np.asarray(integrals.integral[:, column])


def products(pairs: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return ∫ u_p* u_q dx of the displacements that several sets of forces make.

    Parameters
    ----------
    pairs
        ∫ H*(x − α_l) H(x − α_m) dx for every two axles, (lines, axles, axles), m³/N²: over the whole line
        from `axle_pairs`, over the train from `railvib.train_average`.
    force
        Forces at the axles, complex (lines, axles, sets), N.

    Returns
    -------
    ndarray of complex, shape (lines, sets, sets)
        Σ_lm P_lp* P_mq times the pair's integral, m³.
    """
    return np.asarray(force.conj().swapaxes(1, 2) @ (pairs @ force))
