"""How much interpolation between the frequencies of tables misses, against direct values half-way.

Receivers of one class have the same nodes, and so all but their own values in common. Which wave's phase is
best taken out before interpolating is found by trying: first at the highest place, where most waves lie
between track and receiver, and elsewhere only those that pass there.
"""

from collections.abc import Sequence

import numba
import numpy as np

from railvib import blocks
from railvib.blocks import STENCIL
from railvib.track import Track, track_response
from railvib.transfer import Nodes, Receiver, undamped

_GOOD = 1e-2
"""Share of the tolerance at which no better wave is looked for."""
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

    def reference(
        self,
        receiver: Receiver,
        distance: float,
        rows: Sequence[np.ndarray],
        places: Sequence[np.ndarray],
        slownesses: Sequence[float],
        tolerance: float,
        must: bool,
    ) -> tuple[float, float] | None:
        """Return the slowness of the wave to be taken out, s/m, and the largest relative error with it.

        Parameters
        ----------
        receiver, distance
            The receiver, and the distance that waves travel to it, m.
        rows, places
            Its transfer function at the rows and at the places.
        slownesses
            Of the waves to be tried.
        tolerance
            Error that is asked for.
        must
            Whether there must be an answer; else it is None where no wave brings the error down to that.
        """
        direct = np.array(places)
        # The peak is the field's: under the track for the ground, however far the receiver.
        under = direct if receiver == "rail" else self._under
        size = np.maximum(np.abs(direct), _NOTHING * np.abs(under).max(axis=1, keepdims=True))
        if self.track is not None and receiver in ("rail", 0.0):
            # No wave has a way to go, and the track is put on exactly.
            found = self._rail if receiver == "rail" else self._centre
            error = float((np.abs(found - direct) / size).max())
            return (0.0, error) if must or error <= tolerance else None
        tried = np.asarray(slownesses)
        highest = self._errors(slice(-1, None), rows, direct, size, tried, distance)
        best: tuple[float, float] | None = None
        for each in np.argsort(highest, kind="stable"):
            most = best[1] if best else np.inf if must else tolerance
            if highest[each] > most or (best and best[1] <= _GOOD * tolerance):
                break
            others = self._errors(slice(0, -1), rows, direct, size, tried[each : each + 1], distance)
            error = max(float(highest[each]), float(others[0]))
            if error < most or (best is None and error <= most):
                best = float(tried[each]), error
        return best

    def _errors(
        self,
        which: slice,
        rows: Sequence[np.ndarray],
        direct: np.ndarray,
        size: np.ndarray,
        slownesses: np.ndarray,
        distance: float,
    ) -> np.ndarray:
        """Return the largest relative error at some of the places with each of some waves taken out."""
        first = self._first[which]
        own = slice(first[0], first[-1] + STENCIL)
        value = np.array(rows[own]) * self._inverse[own]
        return np.asarray(
            _largest_errors(
                value.view(float),
                self._row_beta[own],
                self._row_omega[own],
                first - own.start,
                self._weight[which],
                self._beta[which],
                self._omega[which],
                self._force[which].view(float),
                direct[which].view(float),
                size[which],
                slownesses,
                distance,
            )
        )


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _largest_errors(
    value, row_beta, row_omega, first, weight, beta, omega, force, direct, size, slowness, distance
):
    """Return the largest relative error at some places with each wave taken out before interpolating.

    `value`, (rows, 2·nodes), is interpolated without the wave's decay, and multiplied by that at the places
    and by `force`; complex numbers are real and imaginary parts in turn.
    """
    nodes = beta.shape[1]
    out = np.empty(slowness.shape[0])
    term = np.empty((2, nodes))
    total = np.empty((2, nodes))
    for c in range(slowness.shape[0]):
        way = distance if slowness[c] > 0.0 else 0.0
        worst = 0.0
        for i in range(first.shape[0]):
            for j in range(nodes):
                total[0, j] = 0.0
                total[1, j] = 0.0
            for m in range(STENCIL):
                row = first[i] + m
                undamped(slowness[c] * row_omega[row], row_beta[row], way, -1.0, term)
                for j in range(nodes):
                    a = weight[i, m] * value[row, 2 * j]
                    b = weight[i, m] * value[row, 2 * j + 1]
                    total[0, j] += a * term[0, j] - b * term[1, j]
                    total[1, j] += a * term[1, j] + b * term[0, j]
            undamped(slowness[c] * omega[i], beta[i], way, 1.0, term)
            for j in range(nodes):
                a = total[0, j] * term[0, j] - total[1, j] * term[1, j]
                b = total[0, j] * term[1, j] + total[1, j] * term[0, j]
                real = a * force[i, 2 * j] - b * force[i, 2 * j + 1] - direct[i, 2 * j]
                imag = a * force[i, 2 * j + 1] + b * force[i, 2 * j] - direct[i, 2 * j + 1]
                term[0, j] = (real * real + imag * imag) / (size[i, j] * size[i, j])
            for j in range(nodes):
                worst = max(worst, term[0, j])
        out[c] = np.sqrt(worst)
    return out
