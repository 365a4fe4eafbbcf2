"""Tables of the transfer functions of track and ground over wavenumber and frequency.

H̃_R(β, ω) and H̃_G(β, y, ω) of a load on the rail are tabulated over a block of frequencies for one receiver:
the rail, or the ground at one distance, once for every speed, train and approach. `railvib.transfer.tabulate`
makes the blocks; here is how they are read.

Wavenumbers follow one coordinate u at all frequencies of a block, because the peaks of the functions stay at
the waves' slownesses: for u ≤ 1, β = ω·s·u with s a slowness above every wave's; beyond, β goes
geometrically to `largest`. Panels have their edges at fixed u, and Gauss–Legendre nodes in β between them.

Between the frequencies of a table the ground's compliance is interpolated, and the track is put on it
exactly: rails on pads resonate more sharply than damped ground, and would ask for many more frequencies.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any
from weakref import finalize

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.jit import fused_kernel
from railvib.numerics.vector_math import cos_sin, exp
from railvib.numerics.wavenumber_panels import NODE, ORDER, count_below, nodes_between, panel_weights
from railvib.parameters.track import Track
from railvib.transfer.interpolate import Rows, Tables, interpolated, joined
from railvib.transfer.track_response import track_response

Receiver = str | float
"""``"rail"``, or the distance from the centre line in m."""
_NOTHING = 80.0
"""Exponent of decay at which nothing is left of a field, however much damping takes from its peak."""
TOP = 1.3
"""Slowness at u = 1 over that of the slowest wave."""
MOST_DECAY = 60.0
"""Exponent beyond which the decay of a reference wave is cut: nothing is left."""

OWN = {"own": "receiver"}
"""Marks what tables of one block and class of receivers differ in."""


@dataclass(frozen=True)
class TransferBlock:
    """Transfer function of one receiver over one block of frequencies."""

    frequency: np.ndarray = field(metadata={"dims": ("frequency",), "unit": "Hz", "description": "frequency"})
    wavenumber: np.ndarray = field(
        metadata={"dims": ("frequency", "node"), "unit": "rad/m", "description": "wavenumber along the track"}
    )
    transfer: np.ndarray = field(
        metadata={
            "dims": ("frequency", "node"),
            "unit": "m2/N",
            "description": "displacement of the receiver per load on the rail",
            "called_by": "receiver",
            **OWN,
        }
    )
    compliance: np.ndarray | None = field(
        metadata={
            "dims": ("frequency", "node"),
            "unit": "m2/N",
            "description": "displacement of the ground under the track per load on it; none if not known",
        }
    )
    pole: np.ndarray = field(
        metadata={"dims": ("frequency", "term"), "unit": "rad2/m2", "description": "poles z of Q33 in rho2"}
    )
    residue: np.ndarray = field(
        metadata={
            "dims": ("frequency", "term"),
            "unit": "rad2/(m Pa)",
            "description": "residues of Q33 at its poles",
        }
    )
    constant: np.ndarray = field(
        metadata={
            "dims": ("frequency",),
            "unit": "m/Pa",
            "description": "constant of the rational form of Q33",
        }
    )
    fit_error: np.ndarray = field(
        metadata={
            "dims": ("frequency",),
            "unit": "1",
            "description": "largest relative error of the rational form",
        }
    )
    edge: np.ndarray = field(
        metadata={"dims": ("edge",), "unit": "1", "description": "panel edges in the coordinate u"}
    )
    quadrature: tuple[float, ...]
    """Frequencies at which the fit failed and direct quadrature took its place, Hz."""
    receiver: str = field(metadata=OWN)
    """``"rail"`` or ``"ground"``; the transfer function is stored under this name."""
    offset: float = field(metadata=OWN)
    """Distance of the receiver from the centre line, m; NaN on the rail."""
    block: int
    """Index of the block, see `railvib.numerics.frequency_blocks`."""
    level: int
    square_level: int = field(metadata=OWN)
    """Level of the frequencies between which |H̃|² can be interpolated, see `railvib.transfer.intensity`."""
    top_slowness: float
    """Slowness at u = 1, s/m."""
    largest: float
    """Wavenumber at u = 2, rad/m."""
    distance: float = field(metadata=OWN)
    """Distance that waves travel from the track's edge, m; 0 on the rail and under the track."""
    reference_slowness: tuple[float, ...] = field(metadata=OWN)
    """Slowness of the undamped wave that is taken out of each panel before interpolating, s/m."""
    interpolation_error: float = field(metadata=OWN)
    """Largest relative error of interpolation between the frequencies, where it was checked."""
    compliance_error: float
    """Largest relative error of the ground's compliance against direct quadrature, where it was checked."""

    @property
    def nodes(self) -> "Nodes":
        """The nodes of the block."""
        return Nodes(self.top_slowness, self.largest, self.edge)

    @cached_property
    def _reduced(self) -> dict[Track | None, np.ndarray]:
        return {}

    def reduced(self, track: Track | None) -> np.ndarray:
        """Return what is interpolated: the receiver's compliance without the reference waves' decay.

        Without the track, or where the table holds no compliance, the transfer function without it. It is
        kept with the table, which many cases share.
        """
        if track not in self._reduced:
            value = np.empty(self.transfer.shape, complex)
            _times_waves(
                np.ascontiguousarray(self.transfer).view(float),
                _inverse_force(self, track).view(float),
                2.0 * np.pi * self.frequency,
                self.node_slowness,
                np.ascontiguousarray(self.wavenumber),
                self.distance,
                -1.0,
                value.view(float),
            )
            self._reduced[track] = value
        return self._reduced[track]

    def forget_reduced(self) -> None:
        """Let go of what is interpolated: it takes as much memory as the table, and is quickly made again."""
        self._reduced.clear()

    @property
    def node_slowness(self) -> np.ndarray:
        """The slowness of the wave that is taken out at every node, s/m."""
        return np.repeat(self.reference_slowness, ORDER)

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """What others have derived from the table for the cases that share it."""
        return {}

    def part(self, first: int, last: int) -> "TransferBlock":
        """Return the table on some of its panels, from one to another."""
        nodes = slice(ORDER * first, ORDER * (last + 1))
        return replace(
            self,
            wavenumber=self.wavenumber[:, nodes],
            transfer=self.transfer[:, nodes],
            compliance=None if self.compliance is None else self.compliance[:, nodes],
            edge=self.edge[first : last + 2],
            reference_slowness=self.reference_slowness[first : last + 1],
        )

    def last(self, frequency: np.ndarray) -> np.ndarray:
        """Return the wavenumbers beyond which nothing is left of the field at frequencies in Hz, rad/m."""
        carried = 2.0 * np.pi * frequency * self.top_slowness
        return np.asarray(np.maximum(nothing_beyond(self.distance), carried))

    def rows(self, value: np.ndarray) -> Rows:
        """Return values at the table's frequencies and nodes for interpolation at scattered points."""
        return Rows(self.block, self.level, self.top_slowness, self.largest, self.edge, value)

    def shortfall(self, tolerance: float) -> str | None:
        """Return what to say where the table misses a tolerance, else None."""
        if self.interpolation_error <= tolerance:
            return None
        name = "the rail" if self.receiver == "rail" else f"the ground at {self.offset:g} m"
        low, high = blocks.edges(self.block)
        return (
            f"transfer function of {name} from {low:.3g} to {high:.3g} Hz: "
            f"error {self.interpolation_error:.1e} is above the tolerance {tolerance:g}"
        )


@dataclass(frozen=True, eq=False)
class Nodes:
    """The panels and nodes of one block and class of receivers."""

    top_slowness: float
    largest: float
    edge: np.ndarray

    def __eq__(self, other: object) -> bool:
        """Return whether the other nodes are the same."""
        return isinstance(other, Nodes) and self._key == other._key

    def __hash__(self) -> int:
        """Return the hash of all that the nodes follow from."""
        return hash(self._key)

    @property
    def _key(self) -> tuple[float, float, bytes]:
        return self.top_slowness, self.largest, self.edge.tobytes()

    def panel_edges(self, frequency: np.ndarray) -> np.ndarray:
        """Return the panels' edges at frequencies (n,), rad/m, (n, edges); not to be written to."""
        return _panel_edges(self, np.asarray(frequency, float).tobytes())

    def panels(self, frequency: np.ndarray, wavenumber: np.ndarray) -> tuple[int, int]:
        """Return the first and the last of the panels that hold pairs of frequency and wavenumber.

        One more on either side, as a pair may lie on an edge.
        """
        dense = 2.0 * np.pi * frequency * self.top_slowness
        beyond = np.log(np.maximum(wavenumber / dense, 1.0)) / np.log(self.largest / dense)
        u = np.minimum(wavenumber / dense, 1.0) + beyond
        panel = np.searchsorted(self.edge, [u.min(), u.max()]) - 1
        return max(int(panel[0]) - 1, 0), min(int(panel[1]) + 1, self.edge.size - 2)

    def wavenumber(self, frequency: np.ndarray) -> np.ndarray:
        """Return the nodes at frequencies (n,), rad/m, (n, node)."""
        return nodes_between(self.panel_edges(frequency))


@lru_cache(64)
def _panel_edges(nodes: Nodes, frequency: bytes) -> np.ndarray:
    """Return edges at frequencies given by their bytes: receivers of one class ask for the same in turn."""
    dense = 2.0 * np.pi * np.frombuffer(frequency)[:, None] * nodes.top_slowness
    edge: np.ndarray = dense * nodes.edge
    (outer,) = np.nonzero(nodes.edge > 1.0)
    edge[:, outer] = dense * (nodes.largest / dense) ** (nodes.edge[outer] - 1.0)
    return edge


@fused_kernel
def _times_waves(value, factor, omega, slowness, beta, distance, sign, out):
    """Write values times a factor times the waves' decay, or over that where the sign is −1.

    Values have real and imaginary parts in turn, (n, 2·m), and so has the factor, in one row for all or in
    as many.
    """
    wave = np.empty((2, beta.shape[1]))
    for i in range(beta.shape[0]):
        undamped(omega[i], slowness, beta[i], distance, sign, wave[0], wave[1])
        own = factor[min(i, factor.shape[0] - 1)]
        for j in range(beta.shape[1]):
            a = value[i, 2 * j] * own[2 * j] - value[i, 2 * j + 1] * own[2 * j + 1]
            b = value[i, 2 * j] * own[2 * j + 1] + value[i, 2 * j + 1] * own[2 * j]
            out[i, 2 * j] = a * wave[0, j] - b * wave[1, j]
            out[i, 2 * j + 1] = a * wave[1, j] + b * wave[0, j]


@fused_kernel
def _carried(first, weight, reduced, edge, omega, slowness, beta, distance):
    """Return what reduced rows give with the waves' decay at points, real and imaginary part, (n, 2).

    The decay is put back at the nodes of a point's panel: what the panels resolve is the whole function,
    while a wave's own decay has a root in it where β is its wavenumber. From one end of a panel to the other
    a field may fall by many orders, and is interpolated without an exponential that falls by as many.
    """
    out = np.empty((beta.shape[0], 2))
    node = np.empty(ORDER)
    row = np.empty(2 * ORDER)
    wave = np.empty((2, ORDER))
    basis = np.empty((ORDER, 1))
    x = np.empty((2, 1))
    one = np.int64(1)
    for i in range(beta.shape[0]):
        p = min(max(count_below(edge[i], beta[i]) - 1, 0), edge.shape[1] - 2)
        middle = 0.5 * (edge[i, p + 1] + edge[i, p])
        half = 0.5 * (edge[i, p + 1] - edge[i, p])
        for j in range(ORDER):
            node[j] = middle + half * NODE[j]
            row[2 * j] = 0.0
            row[2 * j + 1] = 0.0
        for m in range(STENCIL):
            for j in range(2 * ORDER):
                row[j] += weight[i, m] * reduced[first[i] + m, 2 * ORDER * p + j]
        own = slowness[ORDER * p : ORDER * (p + 1)]
        undamped(omega[i], own, node, distance, 1.0, wave[0], wave[1])
        k = omega[i] * own[0]
        fall = np.sqrt(max(edge[i, p + 1] ** 2 - k * k, 0.0)) - np.sqrt(max(edge[i, p] ** 2 - k * k, 0.0))
        slope = min(fall * distance, MOST_DECAY) / (2.0 * half)
        x[0, 0] = (beta[i] - middle) / half
        panel_weights(one, x[0], basis, x[1])
        out[i, 0] = 0.0
        out[i, 1] = 0.0
        for j in range(ORDER):
            basis[j, 0] *= exp(slope * (node[j] - beta[i]))
            out[i, 0] += basis[j, 0] * (row[2 * j] * wave[0, j] - row[2 * j + 1] * wave[1, j])
            out[i, 1] += basis[j, 0] * (row[2 * j] * wave[1, j] + row[2 * j + 1] * wave[0, j])
    return out


@fused_kernel
def undamped(omega, slowness, beta, distance, sign, real, imag):
    """Write e^{∓κ·distance}, κ² = β² − (ω·slowness)², cut where nothing is left; one slowness per β."""
    start = 0
    while start < beta.shape[0]:
        travels = beta[start] < omega * slowness[start]
        end = start + 1
        while end < beta.shape[0] and (beta[end] < omega * slowness[end]) == travels:
            end += 1
        # From 0 in views of their own: so the compiler makes vector code of it.
        b = beta[start:end]
        s = slowness[start:end]
        re = real[start:end]
        im = imag[start:end]
        if travels:
            for j in range(b.shape[0]):
                k = omega * s[j]
                c, t = cos_sin(np.sqrt(abs(k * k - b[j] * b[j])) * distance)
                re[j] = c
                im[j] = -sign * t
        else:
            for j in range(b.shape[0]):
                k = omega * s[j]
                re[j] = exp(-sign * min(np.sqrt(abs(b[j] * b[j] - k * k)) * distance, MOST_DECAY))
                im[j] = 0.0
        start = end


_inverse_forces: dict[tuple[int, Track], np.ndarray] = {}
"""By the compliance that tables have in common, as long as that is held."""


def _inverse_force(table: TransferBlock, track: Track | None) -> np.ndarray:
    """Return the force on the rail per force on the ground, 1 where the track is not put on the table."""
    if track is None or table.compliance is None:
        return np.ones((1, table.transfer.shape[1]), complex)
    key = id(table.compliance), track
    if key not in _inverse_forces:
        omega = 2.0 * np.pi * table.frequency[:, None]
        _inverse_forces[key] = 1.0 / track_response(track, table.wavenumber, omega, table.compliance)[1]
        finalize(table.compliance, _inverse_forces.pop, key, None)
    return _inverse_forces[key]


def nothing_beyond(distance: float) -> float:
    """Return β beyond which nothing is left at a distance from the track of a field that no wave carries.

    That is, beyond u = 1, where the field decays by e^{−√(1 − 1/TOP²) β·distance} at least. In rad/m.
    """
    return float(_NOTHING / (np.sqrt(1.0 - 1.0 / TOP**2) * distance)) if distance > 0.0 else np.inf


class TransferFunction:
    """The transfer function of one receiver over all its blocks.

    Parameters
    ----------
    table
        Its blocks.
    track
        The track on the ground, to be put exactly on interpolated compliances. Without it, as for tables that
        hold no compliance, the transfer function itself is interpolated.
    """

    def __init__(self, table: Iterable[TransferBlock], track: Track | None = None) -> None:
        self.blocks = {each.block: each for each in sorted(table, key=lambda each: each.block)}
        self.track = track
        self.lowest = float(blocks.edges(min(self.blocks))[0])
        self.highest = float(blocks.edges(max(self.blocks))[1])
        self.reach = min(each.largest for each in self.blocks.values())

    @cached_property
    def _under_track(self) -> Tables | None:
        """The ground's compliance under the track over all blocks, if it is known."""
        found = [each.rows(each.compliance) for each in self.blocks.values() if each.compliance is not None]
        return joined(found) if len(found) == len(self.blocks) else None

    @cached_property
    def _rail(self) -> Tables:
        return joined([each.rows(each.transfer) for each in self.blocks.values()])

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

        def between(rows: np.ndarray) -> np.ndarray:
            return blocks.interpolated(block, table.level, frequency, rows)

        def carried(rows: np.ndarray) -> np.ndarray:
            value = between(rows)
            omega = 2.0 * np.pi * frequency
            one = np.ones((1, beta.shape[1]), complex).view(float)
            found = value.view(float)
            _times_waves(found, one, omega, table.node_slowness, beta, table.distance, 1.0, found)
            return value

        return beta, _loaded(table, self.track, frequency, beta, between, carried)

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
            Whether frequencies may lie beyond the tables' upper edge, where the halo of the highest serves.

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
            value = interpolated(self._rail, f, beta)
        else:
            value, _force = track_response(self.track, beta, 2.0 * np.pi * f, interpolated(under, f, beta))
        np.conjugate(value, out=value, where=omega < 0.0)
        return value

    def along(self, frequency: np.ndarray, wavenumber: np.ndarray) -> np.ndarray:
        """Interpolate at one wavenumber per frequency, for any receiver.

        Zero beyond the tables, and where nothing is left of the field, see `TransferBlock.last`.

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
        """
        return self._scattered(frequency, np.abs(wavenumber))

    def _scattered(self, frequency: np.ndarray, wavenumber: np.ndarray) -> np.ndarray:
        """Interpolate at pairs of frequency and wavenumber ≥ 0; zero where nothing is left of the field."""
        which = blocks.assigned(frequency, self.blocks)
        value = np.zeros(wavenumber.shape, complex)
        for block in np.unique(which):
            table = self.blocks[int(block)]
            here = (which == block) & (wavenumber <= np.minimum(table.last(frequency), table.largest))
            if not here.any():
                continue
            f, beta = frequency[here], wavenumber[here]
            # A load that moves steadily asks for few panels: the rest need not be reduced.
            first, last = table.nodes.panels(f, beta)
            if 2 * (last + 1 - first) < table.edge.size - 1:
                table = table.part(first, last)

            value[here] = _at_points(table, self.track, f, beta)
        return value


def _at_points(
    table: TransferBlock, track: Track | None, frequency: np.ndarray, wavenumber: np.ndarray
) -> np.ndarray:
    """Return a transfer function at pairs of frequency and wavenumber inside its table, (n,)."""

    def between(rows: np.ndarray) -> np.ndarray:
        return interpolated(joined([table.rows(rows)]), frequency, wavenumber)[:, None]

    def carried(rows: np.ndarray) -> np.ndarray:
        value = _carried(
            *blocks.stencils(table.block, table.level, frequency),
            rows.view(float),
            table.nodes.panel_edges(frequency),
            2.0 * np.pi * frequency,
            table.node_slowness,
            wavenumber,
            table.distance,
        )
        return np.asarray(value).view(complex)

    return _loaded(table, track, frequency, wavenumber[:, None], between, carried)[:, 0]


def _loaded(
    table: TransferBlock,
    track: Track | None,
    frequency: np.ndarray,
    wavenumber: np.ndarray,
    between: Callable[[np.ndarray], np.ndarray],
    carried: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Return a transfer function at places to which rows of its table are interpolated.

    Parameters
    ----------
    table, track
        The table, and the track to be put on it, as in `TransferFunction`.
    frequency, wavenumber
        The places: Hz, (n,), and rad/m, (n, m).
    between
        Interpolates the rows of an array (frequency, node) of the table to the places.
    carried
        The same with the reference waves' decay put back.

    Returns
    -------
    ndarray of complex, shape (n, m)
        m²/N.
    """
    if track is None or table.compliance is None:
        return carried(table.reduced(track))
    under = between(table.compliance)
    omega = 2.0 * np.pi * frequency[:, None]
    rail, force = track_response(track, wavenumber, omega, under)
    if table.receiver == "rail":
        return rail
    if table.offset == 0.0:
        return np.asarray(force * under)
    force *= carried(table.reduced(track))
    return force
