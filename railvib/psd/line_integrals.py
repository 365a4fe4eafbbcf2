"""Integrals of the squared response along the line: what the moving roughness needs of track and ground.

    M(d, f) = (1/π) ∫₀^∞ |H̃(β, f)|² cos(βd) dβ

at the distances d between axles. M depends on neither speed nor forces, and is smooth in frequency: it is
tabulated at the frequencies of blocks, as the transfer function is, and interpolated to the narrow-band
lines.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_interpolation import interpolate, interpolate_blocks
from railvib.numerics.refinement import search_levels
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.receiver import Receiver
from railvib.psd._kernels.averages import add_cosine_integrals
from railvib.transfer.intensity import group_by_nodes, interpolate_squares, squares_at_level
from railvib.transfer.transfer_function import TransferFunction

_LINES_AT_ONCE = 64
"""Lines whose |H̃|² is in memory at once."""
_CHECKS = 5
"""Places between the frequencies of a level at which interpolation is checked."""
_SHARE = 0.1
"""Share of the tolerance that interpolation between the frequencies may take."""


@dataclass(frozen=True, eq=False)
class LineGrid:
    """Frequencies and distances of line integrals, which receivers with the same levels share."""

    frequency: np.ndarray = field(metadata={"dims": ("frequency",), "unit": "Hz", "description": "frequency"})
    distance: np.ndarray = field(
        metadata={"dims": ("distance",), "unit": "m", "description": "distance between axles"}
    )
    block: np.ndarray = field(metadata={"dims": ("block",), "unit": "", "description": "index of the block"})
    level: np.ndarray = field(
        metadata={"dims": ("block",), "unit": "", "description": "level of the block's frequencies"}
    )


@dataclass(frozen=True)
class LineIntegrals:
    """M(d, f) of one receiver, block after block."""

    grid: LineGrid = field(metadata={"shared_by": "receiver"})
    """Where they are tabulated."""
    integral: np.ndarray = field(
        metadata={
            "dims": ("frequency", "distance"),
            "unit": "m3/N2",
            "description": "line integral of the squared response",
        }
    )
    interpolation_error: np.ndarray = field(
        metadata={
            "dims": ("block",),
            "unit": "1",
            "description": "largest error half-way between frequencies, relative to the integral at 0 m",
        }
    )

    def at(self, frequency: np.ndarray) -> np.ndarray:
        """Interpolate to frequencies (n,) in Hz inside the blocks; (n, distances), m³/N²."""
        return interpolate_blocks(self.grid.block, self.grid.level, frequency, self.integral)


def line_integrals(
    receivers: Mapping[Receiver, TransferFunction],
    distances: npt.ArrayLike,
    block_range: Iterable[int],
    tolerance: float = 1e-4,
    refinement: int = 1,
) -> dict[Receiver, LineIntegrals]:
    """Tabulate M(d, f) of some receivers.

    In each block a receiver takes the first level, from that of its transfer function on, at which
    interpolation passes a check half-way between the frequencies. No result depends on which other receivers
    are asked for.

    Parameters
    ----------
    receivers
        The receivers' transfer functions.
    distances
        Distances d ≥ 0 between axles, m, ascending from 0.
    block_range
        Indices of the blocks, ascending, see `railvib.numerics.frequency_blocks`; the transfer functions are
        tabulated there.
    tolerance
        Error allowed, relative to the integral at distance 0.
    refinement
        For studies of convergence: 2 halves the steps in frequency that the tolerance asks for.
    """
    d = np.asarray(distances, float)
    tabulated: dict[Receiver, list[_Block]] = {receiver: [] for receiver in receivers}
    for block in block_range:
        for receiver, table in _block(receivers, d, block, tolerance, int(np.log2(refinement))).items():
            tabulated[receiver].append(table)
    grids: dict[tuple[int, ...], LineGrid] = {}
    integrals = {}
    for receiver, tables in tabulated.items():
        levels = tuple(table.level for table in tables)
        if levels not in grids:
            frequency = np.concatenate([table.frequency for table in tables])
            grids[levels] = LineGrid(
                frequency, d, np.array([table.block for table in tables]), np.array(levels)
            )
        integrals[receiver] = LineIntegrals(
            grids[levels],
            np.concatenate([table.integral for table in tables]),
            np.array([table.error for table in tables]),
        )
    return integrals


class _Block(NamedTuple):
    """The rows of `LineIntegrals` that belong to one block."""

    block: int
    level: int
    error: float
    frequency: np.ndarray
    integral: np.ndarray


def _block(
    receivers: Mapping[Receiver, TransferFunction],
    distance: np.ndarray,
    block: int,
    tolerance: float,
    beyond: int,
) -> dict[Receiver, _Block]:
    """Tabulate one block, each receiver `beyond` levels above the first that passes its check."""
    functions = {
        receiver: TransferFunction([function.blocks[block]], function.track)
        for receiver, function in receivers.items()
    }

    def tabulate(level: int, pending: Sequence[Receiver]) -> Callable[[Receiver, bool], tuple[_Block, bool]]:
        # All together: receivers that share their nodes share much of the work.
        ks, halfway = blocks.indices(block, level), blocks.halfway_indices(block, level, _CHECKS)
        f, between = blocks.frequency(level, ks), blocks.frequency(level + 1, halfway)
        values = _at_level(
            {receiver: functions[receiver] for receiver in pending}, distance, block, level, ks, halfway
        )

        def check(receiver: Receiver, _required: bool) -> tuple[_Block, bool]:
            tabulated, direct = values[receiver][: f.size], values[receiver][f.size :]
            interpolated = interpolate(block, level, between, tabulated)
            error = float((np.abs(interpolated - direct) / direct[:, :1]).max())
            return _Block(block, level, error, f, tabulated), error <= _SHARE * tolerance

        return check

    start = {receiver: function.blocks[block].level for receiver, function in functions.items()}
    return {
        receiver: table
        for tables in search_levels(start, tabulate, beyond=beyond)
        for receiver, (_level, table) in tables.items()
    }


def _at_level(
    receivers: Mapping[Receiver, TransferFunction],
    distance: np.ndarray,
    block: int,
    level: int,
    ks: np.ndarray,
    halfway: np.ndarray,
) -> dict[Receiver, np.ndarray]:
    """Return M(d, f) at frequencies of a level and, after them, at some of the next, (n, distances)."""
    f = np.concatenate([blocks.frequency(level, ks), blocks.frequency(level + 1, halfway)])
    integral: dict[Receiver, np.ndarray] = {}
    with cost.stage("line integrals") as spent:
        for members, _block, _all in group_by_nodes(receivers, f):
            value = np.empty((len(members), f.size, receivers[members[0]].blocks[block].transfer.shape[1]))
            for out, receiver in zip(value, members, strict=True):
                function = receivers[receiver]
                squares_at_level(function, block, level, ks, out[: ks.size])
                squares_at_level(function, block, level + 1, halfway, out[ks.size :])
                function.blocks[block].discard_reduced()
            edge = receivers[members[0]].blocks[block].nodes.panel_edges(f)
            integral |= zip(members, _integrals(edge, value, distance), strict=True)
            spent.evaluations += value.size
            spent.kernel_calls += len(members)
    return integral


def direct_line_integrals(
    receivers: Mapping[Receiver, TransferFunction],
    distances: npt.ArrayLike,
    frequency: npt.ArrayLike,
) -> dict[Receiver, np.ndarray]:
    """Return M(d, f) of some receivers, integrated at the frequencies themselves.

    Parameters
    ----------
    receivers
        The receivers' tabulated transfer functions.
    distances
        Distances d ≥ 0 between axles, m, ascending.
    frequency
        Frequencies, Hz, (n,), inside the tables.

    Returns
    -------
    dict of ndarray, shape (n, distances)
        m³/N².
    """
    f = np.asarray(frequency, float)
    d = np.asarray(distances, float)
    integral = {receiver: np.empty((f.size, d.size)) for receiver in receivers}
    with cost.stage("line integrals") as spent:
        for start in range(0, f.size, _LINES_AT_ONCE):
            for members, block, inside in group_by_nodes(receivers, f[start : start + _LINES_AT_ONCE]):
                lines = start + inside
                value = interpolate_squares([receivers[receiver] for receiver in members], block, f[lines])
                edge = receivers[members[0]].blocks[block].nodes.panel_edges(f[lines])
                for receiver, rows in zip(members, _integrals(edge, value, d), strict=True):
                    integral[receiver][lines] = rows
                spent.evaluations += value.size
                spent.kernel_calls += len(members)
    return integral


def _integrals(edge: np.ndarray, value: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Return M from |H̃|² on nodes, (receivers, lines, node): (receivers, lines, distances)."""
    integral = np.zeros((value.shape[1], value.shape[0], distance.size))
    scratch = np.zeros((value.shape[0], distance.size))
    add_cosine_integrals(edge, value.reshape(*value.shape[:2], -1, ORDER), distance, integral, scratch)
    return integral.swapaxes(0, 1) / np.pi
