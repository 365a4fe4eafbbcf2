"""The wavenumbers of tables: panels in one coordinate u, with Gauss–Legendre nodes in β between their edges.

The peaks of transfer functions stay at the waves' slownesses. For u ≤ 1, β = ω·s·u with a slowness s above
that of every wave; beyond, β grows geometrically up to a largest wavenumber at u = 2.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from railvib.numerics.wavenumber_panels import nodes_between
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track

TOP = 1.3
"""Slowness at u = 1 over that of the ground's slowest wave."""
_NEGLIGIBLE_DECAY = 80.0
"""Exponent of decay beyond which a field is negligible, however much damping takes from its peak."""


def largest_wavenumber(track: Track, refinement: int = 1) -> float:
    """Return β beyond which the rail on its pads carries the load alone, rad/m: EI β⁴ is 2000 pads."""
    return float(refinement * (2000.0 * track.pad_stiffness / track.rail_bending_stiffness) ** 0.25)


def node_range(
    ground: Ground, track: Track, highest_frequency: float, refinement: int = 1
) -> tuple[float, float]:
    """Return slowness at u = 1, s/m, and wavenumber at u = 2, rad/m, for tables up to a frequency in Hz."""
    top = TOP / ground.slowest_speed
    return top, max(largest_wavenumber(track, refinement), 2.0 * 2.0 * np.pi * highest_frequency * top)


def negligible_beyond(distance: float) -> float:
    """Return β beyond which a field that no wave carries is negligible at a distance from the track, rad/m.

    Beyond u = 1 the field decays at least by e^{−√(1 − 1/TOP²) β·distance}.
    """
    if distance <= 0.0:
        return np.inf
    return float(_NEGLIGIBLE_DECAY / (np.sqrt(1.0 - 1.0 / TOP**2) * distance))


@dataclass(frozen=True, eq=False)
class Nodes:
    """Panels and nodes of the tables of one class of receivers; equal where all their values are."""

    top_slowness: float
    """Slowness at u = 1, s/m."""
    largest: float
    """Wavenumber at u = 2, rad/m."""
    edge: np.ndarray = field(
        metadata={"dims": ("edge",), "unit": "1", "description": "panel edges in the coordinate u"}
    )

    def __eq__(self, other: object) -> bool:
        """Return whether the other nodes are the same."""
        return isinstance(other, Nodes) and self._key == other._key

    def __hash__(self) -> int:
        """Return the hash of all that the nodes follow from."""
        return hash(self._key)

    @property
    def _key(self) -> tuple[float, float, bytes]:
        return self.top_slowness, self.largest, self.edge.tobytes()

    @property
    def panel_count(self) -> int:
        """Number of panels."""
        return self.edge.size - 1

    def part(self, first: int, last: int) -> "Nodes":
        """Return the nodes of some of the panels, from one to another."""
        return Nodes(self.top_slowness, self.largest, self.edge[first : last + 2])

    def panel_edges(self, frequency: np.ndarray) -> np.ndarray:
        """Return the panels' edges at frequencies (n,), rad/m, (n, edges); not to be written to."""
        return _panel_edges(self, np.asarray(frequency, float).tobytes())

    def panels(self, frequency: np.ndarray, wavenumber: np.ndarray) -> tuple[int, int]:
        """Return the first and the last of the panels that hold pairs of frequency and wavenumber.

        They include one more panel on either side, as a pair may lie on an edge.
        """
        dense = 2.0 * np.pi * frequency * self.top_slowness
        beyond = np.log(np.maximum(wavenumber / dense, 1.0)) / np.log(self.largest / dense)
        u = np.minimum(wavenumber / dense, 1.0) + beyond
        panel = np.searchsorted(self.edge, [u.min(), u.max()]) - 1
        return max(int(panel[0]) - 1, 0), min(int(panel[1]) + 1, self.panel_count - 1)

    def wavenumber(self, frequency: np.ndarray) -> np.ndarray:
        """Return the nodes at frequencies (n,), rad/m, (n, node)."""
        return nodes_between(self.panel_edges(frequency))


@lru_cache(64)
def _panel_edges(nodes: Nodes, frequency: bytes) -> np.ndarray:
    """Return edges at frequencies given by their bytes: receivers of a class ask for the same in turn."""
    dense = 2.0 * np.pi * np.frombuffer(frequency)[:, None] * nodes.top_slowness
    edge: np.ndarray = dense * nodes.edge
    (outer,) = np.nonzero(nodes.edge > 1.0)
    edge[:, outer] = dense * (nodes.largest / dense) ** (nodes.edge[outer] - 1.0)
    return edge
