"""|H̃|² at narrow-band lines, on the nodes of the tables: what both approaches integrate over wavenumber.

Squares have no phase, so they can be interpolated themselves. They are tabulated once for all lines, speeds
and trains, at the frequencies of the receiver's table or of a finer level that passes a check half-way;
compliance, track and decay are evaluated in one pass over the nodes of a frequency. The level is found with
the table.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import frequency_interpolation
from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.refinement import MOST_LEVELS, search_level
from railvib.numerics.wavenumber_panels import ORDER, WEIGHT
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.transfer._kernels.intensity import multiply_by_squares, square_rows, squares_on_track
from railvib.transfer.interpolation_error import halfway_places
from railvib.transfer.nodes import Nodes
from railvib.transfer.table import TransferBlock
from railvib.transfer.track_response import track_parameters
from railvib.transfer.transfer_function import TransferFunction

_LEVELS_BEYOND = 3
"""Levels beyond that of the table, between whose frequencies nothing new is known."""
_HALVING = 2.0 ** (STENCIL / 2)
"""Factor by which half the step reduces the error at least, where the phase turns by less than half a turn in
one step: the error goes with sinⁿ of half the turn over the step, n being the length of the stencil."""
_SMALL = 1e-8
"""Share of a square's peak below which errors are relative to it: excitations do not differ by as much."""
_NEGLIGIBLE = 1e-16
"""Share of ∫ |H̃|² below which a panel is skipped: no excitation is stronger than another by that much."""


def group_by_nodes(
    receivers: Mapping[Receiver, TransferFunction], frequency: np.ndarray
) -> Iterator[tuple[list[Receiver], int, np.ndarray]]:
    """Yield receivers whose tables have the same nodes, their block, and which frequencies lie in it."""
    groups: dict[tuple[int, Nodes, bytes], list[Receiver]] = {}
    for receiver, function in receivers.items():
        block_of = blocks.nearest_block(frequency, function.blocks)
        for block in np.unique(block_of):
            # Frequencies in a halo belong to the block that has it.
            rows = np.flatnonzero(block_of == block)
            key = int(block), function.blocks[int(block)].nodes, rows.tobytes()
            groups.setdefault(key, []).append(receiver)
    for (block, _nodes, content), members in groups.items():
        yield members, block, np.frombuffer(content, dtype=np.intp)


def square_level(
    table: TransferBlock,
    track: Track | None,
    place: np.ndarray,
    direct: np.ndarray,
    negligible: np.ndarray,
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
    negligible
        Size of the transfer function below which the table's errors do not count, (places,).
    tolerance
        Relative error allowed, beside that of the table.
    """
    stencils = frequency_interpolation.stencils(
        table.block, table.level, blocks.frequency(table.level + 1, place)
    )
    error = _error(stencils, _square(table.transfer), _square(direct), negligible)
    if error <= tolerance:
        return table.level
    last = max(table.level, min(table.level + _LEVELS_BEYOND, MOST_LEVELS))
    if error <= _HALVING * tolerance or table.level == last:
        return min(table.level + 1, last)

    def check(level: int, required: bool) -> tuple[None, bool]:
        if required:
            return None, True
        places = halfway_places(table.block, level, place.size)
        rows = _evaluate(table, track, blocks.frequency(level, places.row))
        between = _evaluate(table, track, blocks.frequency(level + 1, places.place))
        return None, _error((places.first, places.weight), rows, between, negligible) <= tolerance

    level, _ = search_level(table.level + 1, check, last)
    return level


def _error(
    stencils: tuple[np.ndarray, np.ndarray], rows: np.ndarray, direct: np.ndarray, negligible: np.ndarray
) -> float:
    """Return the largest relative error of rows interpolated to places where the values are known."""
    size = np.maximum(direct, _SMALL * direct.max(axis=1, keepdims=True))
    # The table's own error leaves this much in the square of a negligible function.
    size = np.maximum(size, np.sqrt(direct) * negligible[:, None])
    return float((np.abs(frequency_interpolation.combine_rows(*stencils, rows) - direct) / size).max())


def interpolate_squares(
    functions: Sequence[TransferFunction], block: int, frequency: np.ndarray
) -> np.ndarray:
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
    for out, function in zip(value, functions, strict=True):
        tabulated = squares(function, block)
        frequency_interpolation.combine_rows(
            *frequency_interpolation.stencils(block, tabulated.level, frequency), tabulated.value, out
        )
    return value


class Squares(NamedTuple):
    """|H̃|² on frequencies between which it can be interpolated itself."""

    level: int
    value: np.ndarray
    """(row, node), m⁴/N²."""
    panels: np.ndarray
    """Number of panels from β = 0 on that hold all of ∫ |H̃|² dβ but a negligible share, at every row of a
    stencil; by the stencil's first row."""


def squares(function: TransferFunction, block: int) -> Squares:
    """Return |H̃|² of a receiver on a block's frequencies at its level, track, decay and all.

    It is kept with the table, which many cases share.
    """
    table = function.blocks[block]
    if function.track not in table.derived:
        ks = blocks.indices(block, table.square_level)
        value = squares_at_level(function, block, table.square_level, ks)
        edge = table.nodes.panel_edges(blocks.frequency(table.square_level, ks))
        table.derived[function.track] = Squares(table.square_level, value, _panel_counts(edge, value))
        table.discard_reduced()
    tabulated: Squares = table.derived[function.track]
    return tabulated


def _panel_counts(edge: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return the number of panels that are not negligible, as `Squares` has it."""
    share = (value.reshape(len(value), -1, ORDER) @ WEIGHT) * np.diff(edge)
    needed = share >= _NEGLIGIBLE * share.sum(axis=1, keepdims=True)
    count = share.shape[1] - needed[:, ::-1].argmax(axis=1)
    return np.asarray(sliding_window_view(count, STENCIL).max(axis=1))


def squares_at_level(
    function: TransferFunction, block: int, level: int, ks: np.ndarray, out: np.ndarray | None = None
) -> np.ndarray:
    """Return |H̃|² at some frequencies of a level, from the table's own on, (ks, node).

    Its own values at the table's frequencies, and values interpolated from the table between them. Written to
    `out` if that is given.
    """
    table = function.blocks[block]
    value = np.empty((ks.size, table.transfer.shape[1])) if out is None else out
    step = 2 ** (level - table.level)
    tabulated = ks % step == 0
    rows = ks[tabulated] // step - blocks.indices(block, table.level)[0]
    square_rows(_floats(table.transfer), rows, np.flatnonzero(tabulated), value)
    if not tabulated.all():
        value[~tabulated] = _evaluate(table, function.track, blocks.frequency(level, ks[~tabulated]))
    return value


def _evaluate(table: TransferBlock, track: Track | None, frequency: np.ndarray) -> np.ndarray:
    """Return |H̃|² of a receiver at frequencies of a block, interpolated from its table, (n, node)."""
    edge = table.nodes.panel_edges(frequency)
    omega = 2.0 * np.pi * frequency
    stencils = frequency_interpolation.stencils(table.block, table.level, frequency)
    compliance = table.shared.compliance
    if track is None or compliance is None:
        value = np.ones((frequency.size, table.transfer.shape[1]))
    else:
        forces = table.shared.squared_forces
        key = track, frequency.tobytes()
        follows = table.point.follows(track)
        if follows or key not in forces:
            rail, centre, force = squares_on_track(
                *stencils, _floats(compliance), edge, omega, *track_parameters(track)
            )
            if follows:
                return np.asarray(rail if table.point.on_rail else centre)
            forces[key] = force.copy()
        value = forces[key].copy()
    multiply_by_squares(
        *stencils,
        _floats(table.reduced(track)),
        edge,
        omega,
        table.node_slowness,
        table.distance,
        table.reach(frequency),
        value,
    )
    return value


def _square(value: np.ndarray) -> np.ndarray:
    """Return |values|² of an array of two dimensions."""
    squares = np.empty(value.shape)
    rows = np.arange(len(value))
    square_rows(_floats(value), rows, rows, squares)
    return squares


def _floats(value: np.ndarray) -> np.ndarray:
    """Return complex values as real and imaginary parts in turn."""
    return np.ascontiguousarray(value, complex).view(float)
