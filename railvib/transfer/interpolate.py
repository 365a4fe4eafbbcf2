"""Interpolation in tables of transfer functions at scattered pairs of frequency and wavenumber.

Lagrange in ln f, polynomial in a panel of wavenumbers.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from railvib.numerics.frequency_blocks import STEPS
from railvib.transfer._kernels.interpolation import interpolate_points
from railvib.transfer.nodes import Nodes


class Tables(NamedTuple):
    """Tables of one function over neighbouring blocks, end to end, as compiled kernels read them."""

    value: np.ndarray
    """Row by row, real and imaginary parts in turn."""
    first_block: int
    place: np.ndarray
    """Per block: where its values and its edges start, number of rows, of numbers in a row, and of edges."""
    steps: np.ndarray
    """Frequencies per block."""
    edge: np.ndarray
    """The panels' edges in u."""
    dense: np.ndarray
    """Per block β at u = 1 over the frequency, rad/m/Hz, and its logarithm."""
    largest: np.ndarray
    """Logarithm of β at u = 2."""


class Rows(NamedTuple):
    """The table of one function over one block."""

    block: int
    level: int
    nodes: Nodes
    value: np.ndarray
    """Complex (frequency, node)."""


def join(blocks: Sequence[Rows]) -> Tables:
    """Return the tables of neighbouring blocks, ascending, as one."""
    flat = [np.ascontiguousarray(rows.value, complex).view(float).ravel() for rows in blocks]
    edges = [rows.nodes.edge for rows in blocks]
    starts = np.cumsum([0] + [values.size for values in flat])
    edge_starts = np.cumsum([0] + [edge.size for edge in edges])
    place = [
        (starts[i], edge_starts[i], rows.value.shape[0], 2 * rows.value.shape[1], edges[i].size)
        for i, rows in enumerate(blocks)
    ]
    dense = 2.0 * np.pi * np.array([rows.nodes.top_slowness for rows in blocks])
    return Tables(
        flat[0] if len(flat) == 1 else np.concatenate(flat),
        blocks[0].block,
        np.array(place, np.int64),
        STEPS * 2.0 ** np.array([rows.level for rows in blocks]),
        np.concatenate(edges),
        np.stack([dense, np.log(dense)]),
        np.log([rows.nodes.largest for rows in blocks]),
    )


def interpolate(tables: Tables, frequency: np.ndarray, wavenumber: np.ndarray) -> np.ndarray:
    """Return the values of tables at frequencies in Hz and wavenumbers in rad/m from 0 to their largest."""
    out = np.empty(frequency.size, complex)
    interpolate_points(tables, frequency.ravel(), wavenumber.ravel(), out)
    return out.reshape(frequency.shape)
