"""Errors of interpolation between the frequencies of tables, against direct values half-way.

Receivers of a class have the same nodes, and differ in their values only. A reference wave is taken out of
each panel before interpolating. Which wave leaves the smoothest function differs between panels: a fast wave
does not reach far beyond its own wavenumber, and where several waves travel the slowest phase lies between
theirs. So slownesses over the whole range are tried on every panel: first at some nodes of the highest place,
where most wavelengths lie between track and receiver, then the most promising ones everywhere.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.frequency_interpolation import combine_rows, stencils
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.transfer._kernels.waves import largest_errors
from railvib.transfer.nodes import TOP, Nodes
from railvib.transfer.track_response import track_response

_GOOD_ENOUGH = 0.1
"""Share of the tolerance below which no better wave is looked for."""
_SLOWNESS_COUNT = 10
"""Number of slownesses that are tried."""
_SLOWEST = 1.1
"""The largest of them, over that of the ground's slowest wave."""
_PREVIEW_STRIDE = 4
"""One node of so many shows which slownesses are worth trying everywhere."""
_NEGLIGIBLE = 1e-8
"""Share of the peak below which errors do not count."""


class Places(NamedTuple):
    """Places half-way between the frequencies of a level, and the rows that are interpolated to them."""

    block: int
    level: int
    place: np.ndarray
    """Indices of the places' frequencies at the next level, ascending."""
    row: np.ndarray
    """Indices of the rows' frequencies at this level."""
    first: np.ndarray
    """First of the rows that are interpolated to each place."""
    weight: np.ndarray
    """Weights of these rows, (places, stencil)."""


def halfway_places(block: int, level: int, number: int) -> Places:
    """Return a number of places across a block."""
    place = blocks.halfway_indices(block, level, number)
    first, weight = stencils(block, level, blocks.frequency(level + 1, place))
    rows = np.unique(first[:, None] + np.arange(STENCIL))
    return Places(
        block, level, place, blocks.indices(block, level)[rows], np.searchsorted(rows, first), weight
    )


class HalfwayCheck:
    """Check of the tables of a class at places half-way between their frequencies.

    Parameters
    ----------
    places
        The places.
    nodes
        The nodes of the class.
    track
        The track that is put on interpolated compliances.
    compliance
        The ground's compliance under the track at the rows, on the nodes; None where it is not known, and
        transfer functions are interpolated themselves.
    centre
        The transfer function of the ground at the centre line at the places, on the nodes.
    """

    def __init__(
        self,
        places: Places,
        nodes: Nodes,
        track: Track,
        compliance: Sequence[np.ndarray] | None,
        centre: Sequence[np.ndarray],
    ) -> None:
        self.places = places
        frequency = blocks.frequency(places.level + 1, places.place)
        self._omega = 2.0 * np.pi * frequency
        self._beta = nodes.wavenumber(frequency)
        frequency = blocks.frequency(places.level, places.row)
        self._row_omega = 2.0 * np.pi * frequency
        self._row_beta = nodes.wavenumber(frequency)
        self._slowness = np.linspace(0.0, _SLOWEST / TOP * nodes.top_slowness, _SLOWNESS_COUNT)
        self._direct_centre = np.array(centre)
        self._track = track if compliance is not None else None
        if compliance is None:
            self._inverse_force = np.ones(self._row_beta.shape, complex)
            self._force = np.ones(self._beta.shape, complex)
            return
        rows = np.array(compliance)
        self._inverse_force = 1.0 / track_response(track, self._row_beta, self._row_omega[:, None], rows)[1]
        under = combine_rows(places.first, places.weight, rows)
        self._rail, self._force = track_response(track, self._beta, self._omega[:, None], under)
        self._centre = self._force * under

    def negligible(self, receiver: Receiver, direct: np.ndarray) -> np.ndarray:
        """Return the size below which errors of a transfer function do not count, at each place, m²/N."""
        # The peak is the field's: that under the track for the ground, however far the receiver.
        under = direct if receiver.on_rail else self._direct_centre
        return np.asarray(_NEGLIGIBLE * np.abs(under).max(axis=1))

    def reference_slowness(
        self,
        receiver: Receiver,
        distance: float,
        rows: Sequence[np.ndarray],
        direct: np.ndarray,
        tolerance: float,
        required: bool,
    ) -> tuple[np.ndarray, float] | None:
        """Return the slowness of the wave to be taken out of each panel, s/m, and the largest error.

        Parameters
        ----------
        receiver, distance
            The receiver, and the distance that waves travel to it, m.
        rows, direct
            Its transfer function at the rows, and at the places, (places, node).
        tolerance
            Relative error allowed.
        required
            Whether there must be an answer; else it is None where no waves bring the error below the
            tolerance.
        """
        panels = direct.shape[1] // ORDER
        size = np.maximum(np.abs(direct), self.negligible(receiver, direct)[:, None])
        if self._track is not None and receiver.follows(self._track):
            # No wave travels, and the track is put on exactly.
            interpolated = self._rail if receiver.on_rail else self._centre
            worst = float((np.abs(interpolated - direct) / size).max())
            return (np.zeros(panels), worst) if required or worst <= tolerance else None
        function = _Function(rows, direct, size, distance)
        slowness = self._slowness if distance > 0.0 else np.zeros(1)
        preview = self._preview(function, slowness)
        if not required and preview.min(axis=0).max() > tolerance:
            return None
        best, error = self._best(function, slowness, preview, _GOOD_ENOUGH * tolerance)
        worst = float(error.max())
        return (best, worst) if required or worst <= tolerance else None

    def _preview(self, function: "_Function", slowness: np.ndarray) -> np.ndarray:
        """Return the errors at some nodes of the highest place with each slowness, (slownesses, panels)."""
        rows, nodes = slice(self.places.first[-1], None), slice(1, None, _PREVIEW_STRIDE)
        value = np.array([row[nodes] for row in function.rows[rows]]) * self._inverse_force[rows, nodes]
        panels = function.direct.shape[1] // ORDER
        return self._errors(function, value, slice(-1, None), nodes, slowness[:, None].repeat(panels, axis=1))

    def _best(
        self, function: "_Function", slowness: np.ndarray, preview: np.ndarray, good_enough: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the best slowness of each panel and its error; the most promising ones are tried first."""
        value = np.array(function.rows)
        value *= self._inverse_force
        panels = preview.shape[1]
        best, error = np.zeros(panels), np.full(panels, np.inf)
        untried = preview.copy()
        while True:
            candidate = untried.argmin(axis=0)
            promised = untried[candidate, np.arange(panels)]
            (open_panels,) = np.nonzero((promised < error) & (error > good_enough))
            if not open_panels.size:
                return best, error
            tried = slowness[candidate[open_panels]]
            nodes: slice | np.ndarray = slice(None)
            if open_panels.size < panels:
                nodes = (ORDER * open_panels[:, None] + np.arange(ORDER)).ravel()
            (errors,) = self._errors(function, value[:, nodes], slice(None), nodes, tried[None, :])
            untried[candidate[open_panels], open_panels] = np.inf
            better = errors < error[open_panels]
            best[open_panels[better]], error[open_panels[better]] = tried[better], errors[better]

    def _errors(
        self,
        function: "_Function",
        value: np.ndarray,
        at: slice,
        nodes: slice | np.ndarray,
        slowness: np.ndarray,
    ) -> np.ndarray:
        """Return the largest relative errors at some places and nodes with waves taken out, (sets, panels).

        `value` holds the rows that these places need at these nodes. `slowness` holds sets of the slownesses
        of the panels' waves, of the same shape as what is returned.
        """
        first = self.places.first[at]
        rows = slice(first[0], first[-1] + STENCIL)

        def on_nodes(values: np.ndarray) -> np.ndarray:
            return np.ascontiguousarray(values[:, nodes])

        row_beta = on_nodes(self._row_beta[rows])
        panels = slowness.shape[1]
        return np.asarray(
            largest_errors(
                np.ascontiguousarray(value).view(float),
                (row_beta, self._row_omega[rows]),
                (first - rows.start, self.places.weight[at]),
                (on_nodes(self._beta[at]), self._omega[at]),
                on_nodes(self._force[at]).view(float),
                on_nodes(function.direct[at]).view(float),
                on_nodes(function.size[at]),
                slowness.repeat(row_beta.shape[1] // panels, axis=1),
                panels,
                function.distance,
            )
        )


class _Function(NamedTuple):
    """A receiver's transfer function at the rows and at the places."""

    rows: Sequence[np.ndarray]
    direct: np.ndarray
    size: np.ndarray
    """What errors are relative to, (places, node)."""
    distance: float
    """Distance that waves travel, m."""
