"""|H̃|² at narrow-band lines, on the nodes of the tables: what both approaches integrate over wavenumber.

Squares know no phase, and so they can be interpolated themselves: they are tabulated once for all lines,
speeds and trains, where the receiver's table is or on a finer level that passes a check half-way, and all
that leads to them (compliance, track, decay) runs in one pass over the nodes of a frequency. The level is
found when the table is made, which knows it.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_blocks import STENCIL, combine
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import LANES, exp
from railvib.numerics.wavenumber_panels import NODE, ORDER, WEIGHT
from railvib.parameters.track import Track
from railvib.transfer.nodes import Nodes
from railvib.transfer.table import MOST_DECAY, Receiver, TransferBlock
from railvib.transfer.track_response import load, parameters
from railvib.transfer.transfer_function import TransferFunction

_LEVELS_BEYOND, _MOST_LEVELS = 3, 6
"""Levels beyond that of the table, between whose frequencies nothing new is known, and levels at all."""
_HALVING = 2.0 ** (STENCIL / 2)
"""How much smaller the error is at least with half the step, for what turns by less than half a turn in one:
it goes with sinⁿ of half the turn over the step, n being the length of the stencil."""
_SMALL = 1e-8
"""Of a square's peak, below which errors are relative to that: excitations do not differ by as much."""
_NEGLIGIBLE = 1e-16
"""Share of ∫ |H̃|² below which a panel is passed over: no excitation is stronger than another by that much."""


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


def square_level(
    table: TransferBlock,
    track: Track | None,
    place: np.ndarray,
    direct: np.ndarray,
    nothing: np.ndarray,
    tolerance: float,
) -> int:
    """Return the first level from a table's own on between whose frequencies |H̃|² can be interpolated.

    Parameters
    ----------
    table
        The table; its own `square_level` does not count.
    track
        The track to be put on it between its frequencies.
    place, direct
        Indices of some frequencies at the next level, half-way between the table's, and the transfer function
        there, (places, node).
    nothing
        Size of the transfer function below which the table's errors do not count, (places,).
    tolerance
        Relative error allowed, beside that of the table.
    """
    first, weight = blocks.stencils(table.block, table.level, blocks.frequency(table.level + 1, place))
    error = _error(first, weight, _square(table.transfer), _square(direct), nothing)
    if error <= tolerance:
        return table.level
    last = max(table.level, min(table.level + _LEVELS_BEYOND, _MOST_LEVELS))
    if error <= _HALVING * tolerance:
        return min(table.level + 1, last)
    for level in range(table.level + 1, last):
        between = blocks.frequency(level + 1, blocks.halfway(table.block, level, place.size))
        first, weight = blocks.stencils(table.block, level, between)
        rows = np.unique(first[:, None] + np.arange(STENCIL))
        near = _evaluated(
            table,
            track,
            blocks.frequency(level, blocks.indices(table.block, level)[rows]),
        )
        first = np.searchsorted(rows, first)
        if _error(first, weight, near, _evaluated(table, track, between), nothing) <= tolerance:
            return level
    return last


def _error(
    first: np.ndarray, weight: np.ndarray, rows: np.ndarray, direct: np.ndarray, nothing: np.ndarray
) -> float:
    """Return the largest relative error of rows interpolated to places where the values are known."""
    size = np.maximum(direct, _SMALL * direct.max(axis=1, keepdims=True))
    # What the table's own error makes of a square, where the function is next to nothing.
    size = np.maximum(size, np.sqrt(direct) * nothing[:, None])
    return float((np.abs(blocks.combined(first, weight, rows) - direct) / size).max())


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
        m⁴/N².
    """
    value = np.empty((len(functions), frequency.size, functions[0].blocks[block].transfer.shape[1]))
    stencils: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    for out, function in zip(value, functions, strict=True):
        tabulated = squares(function, block)
        if tabulated.level not in stencils:
            stencils[tabulated.level] = blocks.stencils(block, tabulated.level, frequency)
        blocks.combined(*stencils[tabulated.level], tabulated.value, out)
    return value


class Squares(NamedTuple):
    """|H̃|² on frequencies between which it can be interpolated itself."""

    level: int
    value: np.ndarray
    """(row, node), m⁴/N²."""
    panels: np.ndarray
    """How many panels from β = 0 on hold all of ∫ |H̃|² dβ but a negligible share at any of the rows of a
    stencil, by its first row."""


def squares(function: TransferFunction, block: int) -> Squares:
    """Return |H̃|² of a receiver on a block's frequencies at its level, track, decay and all.

    It is kept with the table, which many cases share.
    """
    table = function.blocks[block]
    if function.track not in table.derived:
        ks = blocks.indices(block, table.square_level)
        value = squared_at(function, block, table.square_level, ks)
        edge = table.nodes.panel_edges(blocks.frequency(table.square_level, ks))
        table.derived[function.track] = Squares(table.square_level, value, _panels(edge, value))
        table.discard_reduced()
    tabulated: Squares = table.derived[function.track]
    return tabulated


def _panels(edge: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return what `Squares` says of panels."""
    share = (value.reshape(len(value), -1, ORDER) @ WEIGHT) * np.diff(edge)
    needed = share >= _NEGLIGIBLE * share.sum(axis=1, keepdims=True)
    panels = share.shape[1] - needed[:, ::-1].argmax(axis=1)
    return np.asarray(sliding_window_view(panels, STENCIL).max(axis=1))


def squared_at(
    function: TransferFunction, block: int, level: int, ks: np.ndarray, out: np.ndarray | None = None
) -> np.ndarray:
    """Return |H̃|² at some frequencies of a level, from the table's own on, (ks, node).

    At the table's own frequencies as it has it, and between them as it interpolates it. Written to `out` if
    that is given.
    """
    table = function.blocks[block]
    value = np.empty((ks.size, table.transfer.shape[1])) if out is None else out
    step = 2 ** (level - table.level)
    there = ks % step == 0
    rows = ks[there] // step - blocks.indices(block, table.level)[0]
    _squares(_floats(table.transfer), rows, np.flatnonzero(there), value)
    if not there.all():
        value[~there] = _evaluated(table, function.track, blocks.frequency(level, ks[~there]))
    return value


def _evaluated(table: TransferBlock, track: Track | None, frequency: np.ndarray) -> np.ndarray:
    """Return |H̃|² of a receiver at frequencies of a block from what its table interpolates, (n, node)."""
    edge = table.nodes.panel_edges(frequency)
    omega = 2.0 * np.pi * frequency
    first, weight = blocks.stencils(table.block, table.level, frequency)
    compliance = table.shared.compliance
    if track is None or compliance is None:
        value = np.ones((frequency.size, table.transfer.shape[1]))
    else:
        forces = table.shared.squared_forces
        key = track, frequency.tobytes()
        under_track = table.receiver == "rail" or table.offset == 0.0
        if under_track or key not in forces:
            rail, centre, force = _on_track(
                first, weight, _floats(compliance), edge, omega, *parameters(track)
            )
            if under_track:
                return np.asarray(rail if table.receiver == "rail" else centre)
            forces[key] = force.copy()
        value = forces[key].copy()
    _times_squares(
        first,
        weight,
        _floats(table.reduced(track)),
        edge,
        omega,
        table.node_slowness,
        table.distance,
        table.last(frequency),
        value,
    )
    return value


def _square(value: np.ndarray) -> np.ndarray:
    """Return |values|² of an array of two dimensions."""
    squares = np.empty(value.shape)
    rows = np.arange(len(value))
    _squares(_floats(value), rows, rows, squares)
    return squares


def _floats(table: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(table, complex).view(float)


@fused_kernel
def _squares(value, rows, places, out):
    """Write |rows|² of values, real and imaginary parts in turn, to rows of others."""
    for i in range(rows.shape[0]):
        row = value[rows[i]]
        for j in range(out.shape[1]):
            out[places[i], j] = row[2 * j] * row[2 * j] + row[2 * j + 1] * row[2 * j + 1]


@fused_kernel
def _on_track(first, weight, compliance, edge, omega, bed, support, pad, rail):
    """Return |H̃|² of the rail and of the ground under it, and |ground's force|²; (3, lines, nodes)."""
    nodes = ORDER * (edge.shape[1] - 1)
    out = np.empty((3, edge.shape[0], nodes))
    q = np.empty(6 * LANES)
    under = np.empty(2 * nodes)
    beta = np.empty(nodes)
    for i in range(edge.shape[0]):
        _nodes_below(np.inf, edge[i], beta)
        combine(first[i], weight[i], compliance, under)
        for start in range(0, nodes, LANES):
            m = min(LANES, nodes - start)
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


@fused_kernel
def _times_squares(first, weight, reduced, edge, omega, slowness, distance, last, out):
    """Multiply by |interpolated rows|² e^{−2κ·distance}, κ² = β² − (ω·slowness)², on panels below `last`."""
    row = np.empty(2 * out.shape[1])
    beta = np.empty(out.shape[1])
    for i in range(out.shape[0]):
        end = _nodes_below(last[i], edge[i], beta)
        combine(first[i], weight[i], reduced, row[: 2 * end])
        for j in range(end):
            square = row[2 * j] * row[2 * j] + row[2 * j + 1] * row[2 * j + 1]
            k = omega[i] * slowness[j]
            kappa = np.sqrt(max(beta[j] * beta[j] - k * k, 0.0))
            out[i, j] *= square * exp(-2.0 * min(kappa * distance, MOST_DECAY))
        for j in range(end, out.shape[1]):
            out[i, j] = 0.0


@fused_kernel
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
