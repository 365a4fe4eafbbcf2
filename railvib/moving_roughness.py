"""The moving-roughness approach: the train stands, the roughness is pulled through under its wheels.

Averaged over the whole line, the response to forces P_l needs the transfer function only through

    M(d, f) = (1/π) ∫₀^∞ |H̃(β, f)|² cos(βd) dβ

at the distances d between axles (Parseval): independent of speed, and computed once for every speed and both
forms of the approach.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numba
import numpy as np
import numpy.typing as npt

from railvib import cost
from railvib.panels import ORDER, fourier_integrals
from railvib.transfer import Receiver, TransferFunction, same_nodes, together

_LINES_AT_ONCE = 64


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
    receivers: Mapping[Receiver, TransferFunction], distances: npt.ArrayLike, frequency: npt.ArrayLike
) -> dict[Receiver, LineIntegrals]:
    """Return M(d, f) of some receivers at some distances and frequencies.

    Parameters
    ----------
    receivers
        The receivers' tabulated transfer functions.
    distances
        Distances between axles, m; the integral is even in them, and each counts once.
    frequency
        Frequencies, Hz, (n,), inside the tables.
    """
    f = np.asarray(frequency, float)
    d = np.unique(np.abs(np.asarray(distances, float)))
    integral = {receiver: np.empty((f.size, d.size)) for receiver in receivers}
    with cost.stage("line integrals") as spent:
        for start in range(0, f.size, _LINES_AT_ONCE):
            here = np.arange(start, min(start + _LINES_AT_ONCE, f.size))
            for members, block, own in same_nodes(receivers, f[here]):
                rows = here[own]
                transfer = together([receivers[each] for each in members], block, f[rows])
                edge = receivers[members[0]].blocks[block].nodes.panel_edges(f[rows])
                found = _cosine_integrals(edge, transfer, d)
                for receiver, each in zip(members, found.swapaxes(0, 1), strict=True):
                    integral[receiver][rows] = each
                spent.evaluations += transfer.size
                spent.kernel_calls += len(members)
    return {receiver: LineIntegrals(f, d, each / np.pi) for receiver, each in integral.items()}


@numba.njit(cache=True, error_model="numpy")
def _cosine_integrals(edge, transfer, distance):
    """Return ∫ |H̃|² cos(βd) dβ, (lines, receivers, distances), over all panels with something in them."""
    receivers, lines, nodes = transfer.shape
    panels = nodes // ORDER
    out = np.zeros((lines, receivers, distance.shape[0]))
    sine = np.zeros((receivers, distance.shape[0]))
    squared = np.empty((receivers, panels, ORDER))
    centre = np.empty(panels)
    half = np.empty(panels)
    needed = np.empty(panels, np.bool_)
    size = np.empty(panels)
    for i in range(lines):
        for p in range(panels):  # in loops: Numba takes seconds to compile assignments to slices
            needed[p] = False
        for q in range(receivers):
            _mark_panels(edge[i], transfer[q, i], squared[q], size, needed)
        kept = 0
        for p in range(panels):
            if not needed[p]:
                continue
            half[kept] = 0.5 * (edge[i, p + 1] - edge[i, p])
            centre[kept] = 0.5 * (edge[i, p + 1] + edge[i, p])
            for q in range(receivers):
                for j in range(ORDER):
                    squared[q, kept, j] = squared[q, p, j]
            kept += 1
        fourier_integrals(centre[:kept], half[:kept], squared, distance, out[i], sine)
    return out


@numba.njit(cache=True, error_model="numpy")
def _mark_panels(edge, transfer, squared, size, needed):
    """Write |H̃|² of one receiver by panels, and mark those with more than a negligible share."""
    total = 0.0
    for p in range(squared.shape[0]):
        for j in range(ORDER):
            h = transfer[p * ORDER + j]
            squared[p, j] = h.real * h.real + h.imag * h.imag
        size[p] = 0.0
        for j in range(ORDER):
            size[p] = max(size[p], (edge[p + 1] - edge[p]) * squared[p, j])
        total += size[p]
    for p in range(squared.shape[0]):
        if size[p] > 1e-14 * total:
            needed[p] = True
        else:  # nothing, also where another receiver needs the panel: no receiver depends on the others
            for j in range(ORDER):
                squared[p, j] = 0.0


def axle_pairs(integrals: LineIntegrals, axle_position: np.ndarray, rows: slice = slice(None)) -> np.ndarray:
    """Return M(α_l − α_m, f) for every two axles on some or all lines, (lines, axles, axles), m³/N²."""
    return np.asarray(integrals.integral[rows][:, _columns(integrals.distance, axle_position)])


def _columns(distance: np.ndarray, axle_position: np.ndarray) -> np.ndarray:
    """Return which of ascending distances every two axles have, (axles, axles)."""
    between = np.round(np.abs(axle_position[:, None] - axle_position[None, :]), 9)
    return np.asarray(np.searchsorted(distance, between - 1e-8))


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
    return np.asarray(force.conj().swapaxes(1, 2) @ _responses(pairs, force))


def force_products(force: np.ndarray) -> np.ndarray:
    """Return Σ_s P_ls* P_ms over sets of forces (lines, axles, sets): (lines, axles, axles), N²."""
    return np.asarray(force.conj() @ force.swapaxes(1, 2))


def line_means(
    integrals: Mapping[Receiver, LineIntegrals], rows: slice, axle_position: np.ndarray, product: np.ndarray
) -> dict[Receiver, np.ndarray]:
    """Return ∫ |u|² dx over the whole line of the displacements that forces make at some receivers.

    Parameters
    ----------
    integrals
        M(d, f) of the receivers, at the same distances.
    rows
        Which of their lines.
    axle_position
        α, m, (axles,).
    product
        The forces' products from `force_products` at these lines, (lines, axles, axles), N².

    Returns
    -------
    dict of ndarray, shape (lines,)
        Σ_lm P_l* P_m M(α_l − α_m), m³.

    Notes
    -----
    M is real and even, so that only the real part of the products counts, summed by distance.
    """
    distance = next(iter(integrals.values())).distance
    column = _columns(distance, axle_position).ravel()
    order = np.argsort(column, kind="stable")
    found, first = np.unique(column[order], return_index=True)
    summed = np.add.reduceat(product.real.reshape(product.shape[0], -1)[:, order], first, axis=1)
    return {
        receiver: np.asarray(np.einsum("fd,fd->f", each.integral[rows][:, found], summed))
        for receiver, each in integrals.items()
    }


def _responses(pairs: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return Σ_m pairs_lm P_mp; real integrals are spared the arithmetic of complex ones."""
    if np.isrealobj(pairs):
        return np.asarray(pairs @ np.ascontiguousarray(force).view(float)).view(complex)
    return np.asarray(pairs @ force)
