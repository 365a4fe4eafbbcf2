"""Tables of the transfer functions of track and ground over wavenumber and frequency.

H̃_R(β, ω) and H̃_G(β, y, ω) of a load on the rail are tabulated over a block of frequencies for one receiver:
the rail, or the ground at one distance, once for every speed, train and approach. `railvib.tabulation` makes
the blocks; here is how they are read.

Wavenumbers follow one coordinate u at all frequencies of a block, because the peaks of the functions stay at
the waves' slownesses: for u ≤ 1, β = ω·s·u with s a slowness above every wave's; beyond, β goes
geometrically to `largest`. Panels have their edges at fixed u, and Gauss–Legendre nodes in β between them.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numba
import numpy as np

from railvib import blocks
from railvib.blocks import STENCIL
from railvib.panels import BARYCENTRIC, NODE, ORDER, nodes_between, stencil_weights
from railvib.vector_math import cos_sin, exp

Receiver = str | float
"""``"rail"``, or the distance from the centre line in m."""


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
    quadrature: np.ndarray = field(
        metadata={
            "dims": ("frequency",),
            "unit": "1",
            "description": "1 where the fit failed and direct quadrature took its place, else 0",
        }
    )
    edge: np.ndarray = field(
        metadata={"dims": ("edge",), "unit": "1", "description": "panel edges in the coordinate u"}
    )
    receiver: str
    """``"rail"`` or ``"ground"``; the transfer function is stored under this name."""
    offset: float
    """Distance of the receiver from the centre line, m; NaN on the rail."""
    block: int
    """Index of the block, see `railvib.blocks`."""
    level: int
    top_slowness: float
    """Slowness at u = 1, s/m."""
    largest: float
    """Wavenumber at u = 2, rad/m."""
    distance: float
    """Distance that waves travel from the track's edge, m; 0 on the rail and under the track."""
    reference_slowness: float
    """Slowness of the undamped wave whose phase is taken out before interpolating, s/m; 0 for none."""
    interpolation_error: float
    """Largest relative error of interpolation between the frequencies, where it was checked."""
    compliance_error: float
    """Largest relative error of the ground's compliance against direct quadrature, where it was checked."""

    @property
    def nodes(self) -> "Nodes":
        """The nodes of the block."""
        return Nodes(self.top_slowness, self.largest, self.edge)

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

    @cached_property
    def reduced(self) -> np.ndarray:
        """The transfer function without the reference wave's decay, (frequency, node)."""
        carried = decay(self.frequency[:, None], self.wavenumber, self.distance, self.reference_slowness)
        return np.asarray(self.transfer / carried)

    def at(self, frequency: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Interpolate to other frequencies of the block, on the nodes.

        Parameters
        ----------
        frequency
            Hz, (n,), inside the block.

        Returns
        -------
        wavenumber, transfer : ndarray, shape (n, node)
            Wavenumbers in rad/m, and the transfer function there in m²/N.
        """
        beta = self.nodes.wavenumber(frequency)
        reduced = blocks.interpolated(self.block, self.level, frequency, self.reduced)
        return beta, reduced * decay(frequency[:, None], beta, self.distance, self.reference_slowness)


@dataclass(frozen=True)
class Nodes:
    """The panels and nodes of one block and class of receivers."""

    top_slowness: float
    largest: float
    edge: np.ndarray

    def panel_edges(self, frequency: np.ndarray) -> np.ndarray:
        """Return the panels' edges at frequencies (n,), rad/m, (n, edges)."""
        dense = 2.0 * np.pi * np.asarray(frequency)[:, None] * self.top_slowness
        u = self.edge
        return np.where(u <= 1.0, dense * u, dense * (self.largest / dense) ** (u - 1.0))

    def wavenumber(self, frequency: np.ndarray) -> np.ndarray:
        """Return the nodes at frequencies (n,), rad/m, (n, node)."""
        return nodes_between(self.panel_edges(frequency))


def decay(frequency: np.ndarray, wavenumber: np.ndarray, distance: float, slowness: float) -> np.ndarray:
    """Return e^{−κ·distance} of an undamped wave, κ² = β² − (ω·slowness)², cut where nothing is left."""
    shape = np.broadcast_shapes(frequency.shape, wavenumber.shape)
    if distance <= 0.0 or slowness <= 0.0:
        return np.ones(shape, complex)
    k = np.broadcast_to(2.0 * np.pi * slowness * frequency, shape)
    beta = np.broadcast_to(wavenumber, shape)
    return np.asarray(_decay(k.ravel(), beta.ravel(), distance)).reshape(shape)


@numba.njit(cache=True, error_model="numpy")
def _decay(k, beta, distance):
    out = np.empty(k.shape[0], np.complex128)
    for i in range(k.shape[0]):
        squared = beta[i] * beta[i] - k[i] * k[i]
        size = np.sqrt(abs(squared)) * distance
        if squared >= 0.0:
            out[i] = exp(-min(size, 60.0))
        else:
            c, s = cos_sin(size)
            out[i] = c - 1j * s
    return out


class TransferFunction:
    """The transfer function of one receiver over all its blocks."""

    def __init__(self, table: Iterable[TransferBlock]) -> None:
        self.blocks = {each.block: each for each in sorted(table, key=lambda each: each.block)}
        self.lowest = float(blocks.edges(min(self.blocks))[0])
        self.highest = float(blocks.edges(max(self.blocks))[1])
        self.reach = min(each.largest for each in self.blocks.values())

    def response(self, wavenumber: np.ndarray, omega: np.ndarray) -> np.ndarray:
        """Interpolate to any wavenumbers and frequencies; for the rail and receivers on the track.

        Parameters
        ----------
        wavenumber
            β, rad/m, (n,), up to the tables' largest.
        omega
            Angular frequency ω̂, rad/s, (n,); negative values give the conjugate, values below the tables the
            static limit.

        Returns
        -------
        ndarray of complex, shape (n,)
            m²/N.

        Raises
        ------
        ValueError
            If a frequency lies above the tables.
        """
        beta = np.abs(wavenumber)
        f = np.maximum(np.abs(omega) / (2.0 * np.pi), self.lowest)
        if f.size and f.max() > self.highest * (1.0 + 1e-9):
            raise ValueError(f"frequency {f.max():g} Hz lies above the tabulated {self.highest:g} Hz")
        which = blocks.assigned(f, self.blocks)
        value = np.empty(beta.shape, complex)
        for block in np.unique(which):
            here = which == block
            table = self.blocks[int(block)]
            at = blocks.position(table.block, table.level, f[here])
            value[here] = _interpolate(
                at, f[here], beta[here], table.transfer, table.edge, table.top_slowness, table.largest
            )
        return np.where(omega < 0.0, value.conj(), value)

    def along(self, frequency: np.ndarray, wavenumber: np.ndarray) -> np.ndarray:
        """Interpolate at one wavenumber per frequency, for any receiver; zero beyond the tables.

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
        beta = np.abs(wavenumber)
        which = blocks.assigned(frequency, self.blocks)
        value = np.empty(beta.shape, complex)
        for block in np.unique(which):
            here = which == block
            table = self.blocks[int(block)]
            f = frequency[here]
            at = blocks.position(table.block, table.level, f)
            inside = beta[here] <= table.largest
            b = np.minimum(beta[here], table.largest)
            reduced = _interpolate(at, f, b, table.reduced, table.edge, table.top_slowness, table.largest)
            carried = reduced * decay(f, b, table.distance, table.reference_slowness)
            value[here] = np.where(inside, carried, 0.0)
        return value


@numba.njit(cache=True, error_model="numpy")
def _interpolate(at, frequency, beta, table, edge, top_slowness, largest):
    """Interpolate a table (frequency, node) at scattered points: Lagrange in ln f, polynomial in a panel."""
    weight = np.empty(STENCIL)
    basis = np.empty(ORDER)
    out = np.empty(beta.shape[0], np.complex128)
    for i in range(beta.shape[0]):
        first = min(max(int(np.floor(at[i])) - STENCIL // 2 + 1, 0), table.shape[0] - STENCIL)
        t = at[i] - first
        stencil_weights(t, weight)
        dense = 2.0 * np.pi * frequency[i] * top_slowness
        u = beta[i] / dense
        if u > 1.0:
            u = min(1.0 + np.log(u) / np.log(largest / dense), 2.0)
        panel = min(max(np.searchsorted(edge, u, side="right") - 1, 0), edge.shape[0] - 2)
        low = dense * edge[panel] if edge[panel] <= 1.0 else dense * (largest / dense) ** (edge[panel] - 1.0)
        high = (
            dense * edge[panel + 1]
            if edge[panel + 1] <= 1.0
            else dense * (largest / dense) ** (edge[panel + 1] - 1.0)
        )
        x = (2.0 * beta[i] - low - high) / (high - low)
        total = 0.0
        exact = -1
        for j in range(ORDER):
            d = x - NODE[j]
            if d == 0.0:
                exact = j
                break
            basis[j] = BARYCENTRIC[j] / d
            total += basis[j]
        value = 0j
        for m in range(STENCIL):
            row = 0j
            if exact >= 0:
                row = table[first + m, panel * ORDER + exact]
            else:
                for j in range(ORDER):
                    row += basis[j] * table[first + m, panel * ORDER + j]
                row /= total
            value += weight[m] * row
        out[i] = value
    return out
