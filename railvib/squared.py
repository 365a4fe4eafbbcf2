"""|H̃|² at narrow-band lines, on the nodes of the tables: what both approaches integrate over wavenumber.

The phase that a wave takes on its way to a receiver does not count here, only its decay. All that leads to a
square runs in one pass over the nodes of a line.
"""

from collections.abc import Iterator, Mapping, Sequence

import numba
import numpy as np

from railvib import blocks
from railvib.blocks import STENCIL
from railvib.panels import NODE, ORDER
from railvib.track import load, parameters
from railvib.transfer import MOST_DECAY, Nodes, Receiver, TransferBlock, TransferFunction
from railvib.vector_math import LANES, exp

_NOTHING = 80.0
"""Exponent of decay at which nothing is left of a field, however much damping takes from its peak."""
_SLOWEST = 0.6
"""Decay per wavenumber, at least, beyond u = 1: √(1 − 1/1.3²) where no wave's slowness exceeds 1/1.3."""


def same_nodes(
    receivers: Mapping[Receiver, TransferFunction], frequency: np.ndarray
) -> Iterator[tuple[list[Receiver], int, np.ndarray]]:
    """Yield receivers whose tables have the same nodes, their block, and which frequencies lie in it."""
    groups: dict[tuple[int, Nodes, bytes], list[Receiver]] = {}
    for receiver, transfer in receivers.items():
        which = blocks.assigned(frequency, transfer.blocks)
        for block in np.unique(which):
            # Tables may end at different blocks, whose halos then serve the frequencies beyond.
            own = np.flatnonzero(which == block)
            key = int(block), transfer.blocks[int(block)].nodes, own.tobytes()
            groups.setdefault(key, []).append(receiver)
    for (block, _nodes, rows), members in groups.items():
        yield members, block, np.frombuffer(rows, dtype=np.intp)


def squared(functions: Sequence[TransferFunction], block: int, frequency: np.ndarray) -> np.ndarray:
    """Return |H̃|² of receivers whose tables have the same nodes, at other frequencies of a block.

    Parameters
    ----------
    functions
        The receivers' transfer functions.
    block
        Index of the block.
    frequency
        Hz, (n,), inside the block.

    Returns
    -------
    ndarray, shape (receivers, n, node)
        m⁴/N². What the receivers share is computed once.
    """
    edge = functions[0].blocks[block].nodes.panel_edges(frequency)
    omega = 2.0 * np.pi * frequency
    value = np.empty((len(functions), frequency.size, ORDER * (edge.shape[1] - 1)))
    last = max(_last(function.blocks[block]) for function in functions)
    on_track: dict[int, np.ndarray] = {}
    for out, function in zip(value, functions, strict=True):
        table = function.blocks[block]
        dense = omega * table.top_slowness
        first, weight = blocks.stencils(block, table.level, frequency)
        out[:] = 1.0
        if function.track is not None and table.compliance is not None:
            if table.level not in on_track:  # receivers of one level share the compliance
                on_track[table.level] = _on_track(
                    first,
                    weight,
                    _floats(table.compliance),
                    edge,
                    omega,
                    np.maximum(last, dense),
                    *parameters(function.track),
                )
            rail, centre, force = on_track[table.level]
            if table.receiver == "rail" or table.offset == 0.0:
                out[:] = rail if table.receiver == "rail" else centre
                continue
            out[:] = force
        _times_squares(
            first,
            weight,
            _floats(table.reduced(function.track)),
            edge,
            omega * table.reference_slowness,
            table.distance if table.reference_slowness > 0.0 else 0.0,
            np.maximum(_last(table), dense),
            out,
        )
    return value


def _last(table: TransferBlock) -> float:
    """Return the wavenumber beyond which nothing is left of a field that no wave carries, rad/m."""
    return _NOTHING / (_SLOWEST * table.distance) if table.distance > 0.0 else np.inf


def _floats(table: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(table, complex).view(float)


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _on_track(first, weight, compliance, edge, omega, last, bed, support, pad, rail):
    """Return |H̃|² of the rail and of the ground under it, and |ground's force|²; (3, lines, nodes).

    On panels that begin below `last`; zero beyond.
    """
    nodes = ORDER * (edge.shape[1] - 1)
    out = np.zeros((3, edge.shape[0], nodes))
    q = np.empty(6 * LANES)
    under = np.empty(2 * nodes)
    beta = np.empty(nodes)
    for i in range(edge.shape[0]):
        end = _nodes_below(last[i], edge[i], beta)
        _interpolated(first[i], weight[i], compliance, under[: 2 * end])
        for start in range(0, end, LANES):
            m = min(LANES, end - start)
            for j in range(m):
                q[j] = under[2 * (start + j)]
                q[LANES + j] = under[2 * (start + j) + 1]
                q[4 * LANES + j] = beta[start + j]
                q[5 * LANES + j] = omega[i]
            load(m, q, bed, support, pad, rail)
            for j in range(m):
                force = 1.0 / (q[2 * LANES + j] ** 2 + q[3 * LANES + j] ** 2)
                c = under[2 * (start + j)] ** 2 + under[2 * (start + j) + 1] ** 2
                out[0, i, start + j] = force * (q[j] ** 2 + q[LANES + j] ** 2)
                out[1, i, start + j] = force * c
                out[2, i, start + j] = force
    return out


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _times_squares(first, weight, reduced, edge, k, distance, last, out):
    """Multiply by |interpolated rows|² e^{−2κ·distance}, κ² = β² − k², on panels that begin below `last`."""
    row = np.empty(2 * out.shape[1])
    beta = np.empty(out.shape[1])
    for i in range(out.shape[0]):
        end = _nodes_below(last[i], edge[i], beta)
        _interpolated(first[i], weight[i], reduced, row[: 2 * end])
        for j in range(end):
            square = row[2 * j] * row[2 * j] + row[2 * j + 1] * row[2 * j + 1]
            kappa = np.sqrt(max(beta[j] * beta[j] - k[i] * k[i], 0.0))
            out[i, j] *= square * exp(-2.0 * min(kappa * distance, MOST_DECAY))
        for j in range(end, out.shape[1]):
            out[i, j] = 0.0


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _nodes_below(last, edge, beta):
    """Write the nodes of the panels that begin below a wavenumber, and return how many they are."""
    end = 0
    while end < edge.shape[0] - 1 and edge[end] < last:
        middle = 0.5 * (edge[end + 1] + edge[end])
        half = 0.5 * (edge[end + 1] - edge[end])
        for j in range(ORDER):
            beta[end * ORDER + j] = middle + half * NODE[j]
        end += 1
    return end * ORDER


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _interpolated(first, weight, table, out):
    """Write weighted sums of neighbouring rows, as many columns as there is room for."""
    for j in range(out.shape[0]):
        total = 0.0
        for m in range(STENCIL):
            total += weight[m] * table[first + m, j]
        out[j] = total
