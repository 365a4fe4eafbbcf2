"""The transfer function of one receiver, read from its tables.

Between the frequencies of a table the ground's compliance is interpolated, and the track is put on it
exactly: rails on pads resonate more sharply than damped ground, and would ask for many more frequencies.
"""

from collections.abc import Callable, Iterable
from functools import cached_property

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import frequency_interpolation
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.track import Track
from railvib.transfer._kernels.waves import interpolate_with_waves, multiply_by_waves
from railvib.transfer.interpolate import Tables, interpolate, join
from railvib.transfer.table import TransferBlock
from railvib.transfer.track_response import track_response


class TransferFunction:
    """The transfer function of one receiver over all its blocks.

    Parameters
    ----------
    tables
        The tables of its blocks.
    track
        The track on the ground, to be put exactly on interpolated compliances. Without it, as for tables that
        hold no compliance, the transfer function itself is interpolated.
    """

    def __init__(self, tables: Iterable[TransferBlock], track: Track | None = None) -> None:
        self.blocks = {table.block: table for table in sorted(tables, key=lambda table: table.block)}
        self.track = track
        self.lowest = float(blocks.edges(min(self.blocks))[0])
        self.highest = float(blocks.edges(max(self.blocks))[1])
        self.reach = min(table.nodes.largest for table in self.blocks.values())

    @cached_property
    def _under_track(self) -> Tables | None:
        """The ground's compliance under the track over all blocks, if it is known."""
        tables = [table.shared for table in self.blocks.values()]
        rows = [table.rows(table.compliance) for table in tables if table.compliance is not None]
        return join(rows) if len(rows) == len(tables) else None

    @cached_property
    def _rail(self) -> Tables:
        return join([table.shared.rows(table.transfer) for table in self.blocks.values()])

    def at(self, block: int, frequency: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Interpolate to other frequencies of a block, on its nodes.

        Parameters
        ----------
        block
            Index of the block.
        frequency
            Hz, (n,), inside the block.

        Returns
        -------
        wavenumber, transfer : ndarray, shape (n, node)
            Wavenumbers in rad/m, and the transfer function there in m²/N.
        """
        table = self.blocks[block]
        beta = table.nodes.wavenumber(frequency)

        def to_places(rows: np.ndarray) -> np.ndarray:
            return frequency_interpolation.interpolate(block, table.level, frequency, rows)

        def with_waves(rows: np.ndarray) -> np.ndarray:
            value = to_places(rows)
            omega = 2.0 * np.pi * frequency
            one = np.ones((1, beta.shape[1]), complex).view(float)
            parts = value.view(float)
            multiply_by_waves(parts, one, omega, table.node_slowness, beta, table.distance, 1.0, parts)
            return value

        return beta, _transfer(table, self.track, frequency, beta, to_places, with_waves)

    def response(self, wavenumber: np.ndarray, omega: np.ndarray, *, into_halo: bool = False) -> np.ndarray:
        """Interpolate the rail's response to any wavenumbers and frequencies.

        Parameters
        ----------
        wavenumber
            β, rad/m, any shape, up to the tables' largest.
        omega
            Angular frequency ω̂, rad/s, of the same shape; negative values give the conjugate, values below
            the tables the static limit.
        into_halo
            Whether frequencies may lie beyond the tables' upper edge, in the halo of the highest.

        Returns
        -------
        ndarray of complex
            m²/N.

        Raises
        ------
        ValueError
            If a frequency lies above the tables.
        """
        beta = np.minimum(np.abs(wavenumber), self.reach)
        f = np.maximum(np.abs(omega) / (2.0 * np.pi), self.lowest)
        if f.size and f.max() > self.highest * (1.0 + 1e-9) and not into_halo:
            raise ValueError(f"frequency {f.max():g} Hz lies above the tabulated {self.highest:g} Hz")
        under = self._under_track
        if self.track is None or under is None:
            value = interpolate(self._rail, f, beta)
        else:
            value, _force = track_response(self.track, beta, 2.0 * np.pi * f, interpolate(under, f, beta))
        np.conjugate(value, out=value, where=omega < 0.0)
        return value

    def covers(self, frequency: np.ndarray, wavenumber: np.ndarray) -> np.ndarray:
        """Return whether pairs of frequency in Hz and wavenumber in rad/m lie in the tables, (n,)."""
        inside = (frequency >= self.lowest * (1.0 - 1e-9)) & (frequency <= self.highest * (1.0 + 1e-9))
        largest = {block: table.nodes.largest for block, table in self.blocks.items()}
        block_of = blocks.nearest_block(frequency, self.blocks)
        return np.asarray(inside & (np.abs(wavenumber) <= np.vectorize(largest.get)(block_of)))

    def along(self, frequency: np.ndarray, wavenumber: np.ndarray) -> np.ndarray:
        """Interpolate at one wavenumber per frequency, for any receiver.

        Zero beyond the tables' largest wavenumber, and where the field is negligible, see
        `TransferBlock.reach`.

        Parameters
        ----------
        frequency
            Hz, (n,), positive.
        wavenumber
            β, rad/m, (n,).

        Returns
        -------
        ndarray of complex, shape (n,)
            m²/N.

        Raises
        ------
        ValueError
            If a frequency lies beyond the tables.
        """
        beta = np.abs(wavenumber)
        blocks.check_coverage(frequency, self.blocks)
        block_of = blocks.nearest_block(frequency, self.blocks)
        value = np.zeros(beta.shape, complex)
        for block in np.unique(block_of):
            table = self.blocks[int(block)]
            inside = (block_of == block) & (beta <= np.minimum(table.reach(frequency), table.nodes.largest))
            if not inside.any():
                continue
            # A load that moves steadily needs few panels: the others are not reduced.
            first, last = table.nodes.panels(frequency[inside], beta[inside])
            if 2 * (last + 1 - first) < table.nodes.panel_count:
                table = table.part(first, last)
            points = _at_points(table, self.track, frequency[inside], beta[inside])
            value[inside] = points * _excess(table, frequency[inside], beta[inside], np.abs(points))
        return value


def _at_points(
    table: TransferBlock, track: Track | None, frequency: np.ndarray, wavenumber: np.ndarray
) -> np.ndarray:
    """Return a transfer function at pairs of frequency and wavenumber inside its table, (n,)."""

    def to_places(rows: np.ndarray) -> np.ndarray:
        return interpolate(join([table.shared.rows(rows)]), frequency, wavenumber)[:, None]

    def with_waves(rows: np.ndarray) -> np.ndarray:
        value = interpolate_with_waves(
            *frequency_interpolation.stencils(table.block, table.level, frequency),
            rows.view(float),
            table.nodes.panel_edges(frequency),
            2.0 * np.pi * frequency,
            table.node_slowness,
            wavenumber,
            table.distance,
        )
        return np.asarray(value).view(complex)

    return _transfer(table, track, frequency, wavenumber[:, None], to_places, with_waves)[:, 0]


def _excess(
    table: TransferBlock, frequency: np.ndarray, wavenumber: np.ndarray, size: np.ndarray
) -> np.ndarray:
    """Return by what to multiply interpolated values so that none exceeds the values around it, (n,).

    Where no wave travels a field falls with wavenumber. Far from the track it falls so fast that the rounding
    of its smallest values, from which the decay is taken out, would return larger than its largest.
    """
    first, _weight = frequency_interpolation.stencils(table.block, table.level, frequency)
    edge = table.nodes.panel_edges(frequency)
    panel = np.clip((edge < wavenumber[:, None]).sum(axis=1) - 1, 0, table.nodes.panel_count - 1)
    rows = first[:, None, None] + np.arange(blocks.STENCIL)[:, None]
    nodes = np.maximum(ORDER * panel[:, None] + np.arange(-ORDER, ORDER), 0)[:, None, :]
    largest = np.abs(table.transfer[rows, nodes]).max(axis=(1, 2))
    falls = wavenumber > 2.0 * np.pi * frequency * table.nodes.top_slowness
    return np.where(falls & (size > largest), largest / np.maximum(size, np.finfo(float).tiny), 1.0)


def _transfer(
    table: TransferBlock,
    track: Track | None,
    frequency: np.ndarray,
    wavenumber: np.ndarray,
    to_places: Callable[[np.ndarray], np.ndarray],
    with_waves: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Return a transfer function at places to which rows of its table are interpolated.

    Parameters
    ----------
    table, track
        The table, and the track to be put on it, as in `TransferFunction`.
    frequency, wavenumber
        The places: Hz, (n,), and rad/m, (n, m).
    to_places
        Interpolates the rows of an array (frequency, node) of the table to the places.
    with_waves
        The same with the reference waves' decay put back.

    Returns
    -------
    ndarray of complex, shape (n, m)
        m²/N.
    """
    if track is None or table.shared.compliance is None:
        return with_waves(table.reduced(track))
    under = to_places(table.shared.compliance)
    omega = 2.0 * np.pi * frequency[:, None]
    rail, force = track_response(track, wavenumber, omega, under)
    if table.point.on_rail:
        return rail
    if table.point.follows(track):
        return np.asarray(force * under)
    force *= with_waves(table.reduced(track))
    return force
