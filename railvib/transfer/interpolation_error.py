"""How much interpolation between the frequencies of tables misses, against direct values half-way.

Receivers of one class have the same nodes, and so all but their own values in common. Which wave's phase is
best taken out before interpolating differs between panels, as fast waves do not reach far beyond their own
wavenumber, and between those that do lies what is slowest to turn: slownesses all over the range are tried
on every panel, first on some nodes at the highest place, where most waves lie between track and receiver, and
the best of them everywhere.
"""

from collections.abc import Sequence

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.jit import fused_kernel
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.track import Track
from railvib.transfer.nodes import TOP, Nodes
from railvib.transfer.table import Receiver, reference_waves
from railvib.transfer.track_response import track_response

_GOOD = 0.1
"""Share of the tolerance at which no better wave is looked for."""
_TRIED = 10
"""Slownesses that are tried."""
_SLOWEST = 1.1
"""The largest of them, over that of the slowest body wave: a surface wave is slower."""
_EVERY = 4
"""One node of so many tells which slownesses are worth a look at all."""
_NOTHING = 1e-8
"""Share of the peak below which errors do not count."""


class Halfway:
    """Places half-way between the frequencies of a level, at which the tables of a class are checked.

    Parameters
    ----------
    nodes
        The nodes of the class.
    block, level
        Of the tables.
    track
        The track to be put on interpolated compliances; None where these are not known.

    Attributes
    ----------
    place
        Indices of the places' frequencies at the next level.
    row
        Indices of the frequencies of this level that are interpolated from.
    """

    def __init__(self, nodes: Nodes, block: int, level: int, track: Track | None, number: int) -> None:
        ks = blocks.indices(block, level)
        self.track = track
        self.place = blocks.halfway(block, level, number)
        f = blocks.frequency(level + 1, self.place)
        first, self._weight = blocks.stencils(block, level, f)
        rows = np.unique(first[:, None] + np.arange(STENCIL))
        self.row = ks[rows]
        self._first = np.searchsorted(rows, first)
        self._omega = 2.0 * np.pi * f
        self._beta = nodes.wavenumber(f)
        f = blocks.frequency(level, self.row)
        self._row_omega = 2.0 * np.pi * f
        self._row_beta = nodes.wavenumber(f)
        self._slownesses = np.linspace(0.0, _SLOWEST / TOP * nodes.top_slowness, _TRIED)
        self._inverse = np.ones(self._row_beta.shape, complex)
        self._force = np.ones(self._beta.shape, complex)

    def put_on(self, compliance: Sequence[np.ndarray], under: Sequence[np.ndarray]) -> None:
        """Tell the ground's compliance under the track at the rows, and the ground under it at the places."""
        self._under = np.array(under)
        if self.track is None:
            return
        rows = np.array(compliance)
        self._inverse = 1.0 / track_response(self.track, self._row_beta, self._row_omega[:, None], rows)[1]
        between = blocks.combined(self._first, self._weight, rows)
        self._rail, self._force = track_response(self.track, self._beta, self._omega[:, None], between)
        self._centre = self._force * between

    def nothing(self, receiver: Receiver, direct: np.ndarray) -> np.ndarray:
        """Return the size below which errors of a transfer function do not count, at each place, m²/N."""
        # The peak is the field's: under the track for the ground, however far the receiver.
        under = direct if receiver == "rail" else self._under
        return np.asarray(_NOTHING * np.abs(under).max(axis=1))

    def references(
        self,
        receiver: Receiver,
        distance: float,
        rows: Sequence[np.ndarray],
        direct: np.ndarray,
        tolerance: float,
        must: bool,
    ) -> tuple[np.ndarray, float] | None:
        """Return the slowness of the wave to be taken out of each panel, s/m, and the largest error.

        Parameters
        ----------
        receiver, distance
            The receiver, and the distance that waves travel to it, m.
        rows, direct
            Its transfer function at the rows, and at the places, (places, node).
        tolerance
            Error that is asked for.
        must
            Whether there must be an answer; else it is None where no waves bring the error down to that.
        """
        panels = direct.shape[1] // ORDER
        size = np.maximum(np.abs(direct), self.nothing(receiver, direct)[:, None])
        if self.track is not None and receiver in ("rail", 0.0):
            # No wave has a way to go, and the track is put on exactly.
            found = self._rail if receiver == "rail" else self._centre
            worst = float((np.abs(found - direct) / size).max())
            return (np.zeros(panels), worst) if must or worst <= tolerance else None
        tried = self._slownesses if distance > 0.0 else np.zeros(1)
        last, some = slice(self._first[-1], None), slice(1, None, _EVERY)
        value = np.array([row[some] for row in rows[last]]) * self._inverse[last, some]
        everywhere = tried[:, None].repeat(panels, axis=1)
        highest = self._errors(value, direct, size, distance, slice(-1, None), some, everywhere)
        if not must and highest.min(axis=0).max() > tolerance:
            return None
        value = np.array(rows)
        value *= self._inverse
        best, error = np.zeros(panels), np.full(panels, np.inf)
        while True:
            candidate = highest.argmin(axis=0)
            promised = highest[candidate, np.arange(panels)]
            (open_,) = np.nonzero((promised < error) & (error > _GOOD * tolerance))
            if not open_.size:
                break
            slowness = tried[candidate[open_]]
            nodes = (ORDER * open_[:, None] + np.arange(ORDER)).ravel()
            all_open = open_.size == panels
            (most,) = self._errors(
                value if all_open else value[:, nodes],
                direct,
                size,
                distance,
                slice(None),
                slice(None) if all_open else nodes,
                slowness[None, :],
            )
            highest[candidate[open_], open_] = np.inf
            better = most < error[open_]
            best[open_[better]], error[open_[better]] = slowness[better], most[better]
        worst = float(error.max())
        return (best, worst) if must or worst <= tolerance else None

    def _errors(
        self,
        value: np.ndarray,
        direct: np.ndarray,
        size: np.ndarray,
        distance: float,
        which: slice,
        nodes: slice | np.ndarray,
        slownesses: np.ndarray,
    ) -> np.ndarray:
        """Return the largest relative errors at some places and nodes with waves taken out, (sets, panels).

        `value` holds the rows that these places need at these nodes. `slownesses` are sets of those of the
        panels' waves, of the same shape.
        """
        first = self._first[which]
        own = slice(first[0], first[-1] + STENCIL)

        def some(values: np.ndarray) -> np.ndarray:
            return np.ascontiguousarray(values[:, nodes])

        beta = some(self._row_beta[own])
        return np.asarray(
            _largest_errors(
                np.ascontiguousarray(value).view(float),
                beta,
                self._row_omega[own],
                first - own.start,
                self._weight[which],
                some(self._beta[which]),
                self._omega[which],
                some(self._force[which]).view(float),
                some(direct[which]).view(float),
                some(size[which]),
                slownesses.repeat(beta.shape[1] // slownesses.shape[1], axis=1),
                slownesses.shape[1],
                distance,
            )
        )


@fused_kernel
def _largest_errors(
    value, row_beta, row_omega, first, weight, beta, omega, force, direct, size, slowness, panels, distance
):
    """Return the largest relative error of each panel at some places with waves taken out, (sets, panels).

    `value`, (rows, 2·nodes), is interpolated without the waves' decay, and multiplied by that at the places
    and by `force`; complex numbers are real and imaginary parts in turn.
    """
    nodes = beta.shape[1]
    own = nodes // panels
    out = np.empty((slowness.shape[0], panels))
    term = np.empty((2, nodes))
    total = np.empty((2, nodes))
    for c in range(slowness.shape[0]):
        for p in range(out.shape[1]):
            out[c, p] = 0.0
        for i in range(first.shape[0]):
            for j in range(nodes):
                total[0, j] = 0.0
                total[1, j] = 0.0
            for m in range(STENCIL):
                row = first[i] + m
                reference_waves(row_omega[row], slowness[c], row_beta[row], distance, -1.0, term[0], term[1])
                for j in range(nodes):
                    a = weight[i, m] * value[row, 2 * j]
                    b = weight[i, m] * value[row, 2 * j + 1]
                    total[0, j] += a * term[0, j] - b * term[1, j]
                    total[1, j] += a * term[1, j] + b * term[0, j]
            reference_waves(omega[i], slowness[c], beta[i], distance, 1.0, term[0], term[1])
            for j in range(nodes):
                a = total[0, j] * term[0, j] - total[1, j] * term[1, j]
                b = total[0, j] * term[1, j] + total[1, j] * term[0, j]
                real = a * force[i, 2 * j] - b * force[i, 2 * j + 1] - direct[i, 2 * j]
                imag = a * force[i, 2 * j + 1] + b * force[i, 2 * j] - direct[i, 2 * j + 1]
                term[0, j] = (real * real + imag * imag) / (size[i, j] * size[i, j])
            for p in range(out.shape[1]):
                for j in range(own * p, own * (p + 1)):
                    out[c, p] = max(out[c, p], term[0, j])
    return np.sqrt(out)
