"""Tables of the transfer functions of track and ground over wavenumber and frequency.

H̃_R(β, ω) and H̃_G(β, y, ω) of a load on the rail are tabulated over a block of frequencies for one receiver:
the rail, or the ground at one distance, once for every speed, train and approach. `railvib.transfer.tabulate`
makes the tables, `railvib.transfer.transfer_function` reads them.

Receivers at similar distances form a class. Their tables have the same nodes and the same ground under the
track; what they have in common is a `SharedTable`, to which each of them refers.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.track import Track
from railvib.transfer._kernels.waves import multiply_by_waves
from railvib.transfer.interpolate import Rows
from railvib.transfer.nodes import Nodes, negligible_beyond
from railvib.transfer.track_response import track_response


@dataclass(frozen=True, eq=False)
class SharedTable:
    """What the tables of a class of receivers have in common over one block, at one level of frequencies."""

    frequency: np.ndarray = field(metadata={"dims": ("frequency",), "unit": "Hz", "description": "frequency"})
    wavenumber: np.ndarray = field(
        metadata={"dims": ("frequency", "node"), "unit": "rad/m", "description": "wavenumber along the track"}
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
    quadrature: tuple[float, ...]
    """Frequencies at which the fit failed and direct quadrature took its place, Hz."""
    block: int
    """Index of the block, see `railvib.numerics.frequency_blocks`."""
    level: int
    """Level of the frequencies."""
    nodes: Nodes = field(metadata={"shared_by": "level"})
    """The nodes, which are the same at every level."""
    compliance_error: float
    """Largest relative error of the ground's compliance against direct quadrature, where it was checked."""

    @cached_property
    def _inverse_forces(self) -> dict[Track, np.ndarray]:
        return {}

    def inverse_force(self, track: Track | None) -> np.ndarray:
        """Return the force on the rail per force on the ground, (frequency, node).

        One row of ones without a track, or where the compliance is not known.
        """
        if track is None or self.compliance is None:
            return np.ones((1, self.wavenumber.shape[1]), complex)
        if track not in self._inverse_forces:
            omega = 2.0 * np.pi * self.frequency[:, None]
            _rail, force = track_response(track, self.wavenumber, omega, self.compliance)
            self._inverse_forces[track] = 1.0 / force
        return self._inverse_forces[track]

    @cached_property
    def squared_forces(self) -> dict[tuple[Track, bytes], np.ndarray]:
        """|Force on the ground|² per force on the rail, by track and the bytes of frequencies in Hz.

        `railvib.transfer.intensity` computes it once for all receivers of the class.
        """
        return {}

    def part(self, first: int, last: int) -> "SharedTable":
        """Return the table on some of its panels, from one to another."""
        nodes = slice(ORDER * first, ORDER * (last + 1))
        return replace(
            self,
            wavenumber=self.wavenumber[:, nodes],
            compliance=None if self.compliance is None else self.compliance[:, nodes],
            nodes=self.nodes.part(first, last),
        )

    def rows(self, value: np.ndarray) -> Rows:
        """Return values at the table's frequencies and nodes for interpolation at scattered points."""
        return Rows(self.block, self.level, self.nodes, value)


@dataclass(frozen=True)
class TransferBlock:
    """Transfer function of one receiver over one block of frequencies."""

    shared: SharedTable = field(metadata={"shared_by": "receiver"})
    """What it has in common with other receivers of its class."""
    transfer: np.ndarray = field(
        metadata={
            "dims": ("frequency", "node"),
            "unit": "m2/N",
            "description": "displacement of the receiver per load on the rail",
            "called_by": "receiver",
        }
    )
    receiver: str
    """``"rail"`` or ``"ground"``; the transfer function is stored under this name."""
    offset: float
    """Distance of the receiver from the centre line, m; NaN on the rail."""
    square_level: int
    """Level of the frequencies between which |H̃|² can be interpolated, see `railvib.transfer.intensity`."""
    distance: float
    """Distance that waves travel from the track's edge, m; 0 on the rail and under the track."""
    reference_slowness: tuple[float, ...]
    """Slowness of the undamped wave that is taken out of each panel before interpolating, s/m."""
    interpolation_error: float
    """Largest relative error of interpolation between the frequencies, where it was checked."""

    @property
    def point(self) -> Receiver:
        """The receiver."""
        return RAIL if self.receiver == "rail" else Receiver(self.offset)

    @property
    def block(self) -> int:
        """Index of the block, see `railvib.numerics.frequency_blocks`."""
        return self.shared.block

    @property
    def level(self) -> int:
        """Level of the frequencies."""
        return self.shared.level

    @property
    def nodes(self) -> Nodes:
        """The nodes of the block."""
        return self.shared.nodes

    @cached_property
    def _reduced(self) -> dict[Track | None, np.ndarray]:
        return {}

    def reduced(self, track: Track | None) -> np.ndarray:
        """Return the function to be interpolated: the receiver's compliance without the waves' decay.

        Without a track, or where the table holds no compliance, it is the transfer function without that
        decay. It is kept with the table, which many cases share.
        """
        if track not in self._reduced:
            value = np.empty(self.transfer.shape, complex)
            multiply_by_waves(
                np.ascontiguousarray(self.transfer).view(float),
                self.shared.inverse_force(track).view(float),
                2.0 * np.pi * self.shared.frequency,
                self.node_slowness,
                np.ascontiguousarray(self.shared.wavenumber),
                self.distance,
                -1.0,
                value.view(float),
            )
            self._reduced[track] = value
        return self._reduced[track]

    def discard_reduced(self) -> None:
        """Discard the functions to be interpolated, which take as much memory as the table."""
        self._reduced.clear()

    @property
    def node_slowness(self) -> np.ndarray:
        """The slowness of the wave that is taken out at every node, s/m."""
        return np.repeat(self.reference_slowness, ORDER)

    @cached_property
    def derived(self) -> dict[Any, Any]:
        """Quantities that other modules derive from the table, kept for the cases that share it."""
        return {}

    def part(self, first: int, last: int) -> "TransferBlock":
        """Return the table on some of its panels, from one to another."""
        return replace(
            self,
            shared=self.shared.part(first, last),
            transfer=self.transfer[:, ORDER * first : ORDER * (last + 1)],
            reference_slowness=self.reference_slowness[first : last + 1],
        )

    def reach(self, frequency: np.ndarray) -> np.ndarray:
        """Return the wavenumbers beyond which the field is negligible at frequencies in Hz, rad/m."""
        carried = 2.0 * np.pi * frequency * self.nodes.top_slowness
        return np.asarray(np.maximum(negligible_beyond(self.distance), carried))

    def shortfall(self, tolerance: float) -> str | None:
        """Return a message if the table misses a tolerance, else None."""
        if self.interpolation_error <= tolerance:
            return None
        low, high = blocks.edges(self.block)
        return (
            f"transfer function of {self.point.title} from {low:.3g} to {high:.3g} Hz: "
            f"error {self.interpolation_error:.1e} is above the tolerance {tolerance:g}"
        )
