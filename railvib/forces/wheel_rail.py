"""Wheel–rail forces of a train on uneven rails.

    [Σ_T + Σ_R + I/k_H] P = −w̃        (Eq. 12)

With the rail's standing receptances these are the forces of moving roughness, with the moving ones those of
the full model; nothing else differs.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from railvib import cost
from railvib.forces._kernels.axle_system import solve
from railvib.forces.receptance import Receptances
from railvib.numerics.vector_math import phasors
from railvib.parameters.vehicle import Block, Train, train_receptance

_MOST_GROWTH = 1e3
"""Largest product of the factors' entries, relative to the matrix, for which rows keep their order: at most
three of 16 digits are lost.
"""


def force_matrices(train: Train, rail: Receptances, frequency: np.ndarray) -> np.ndarray:
    """Return the forces at all axles per unit unevenness at one axle.

    Parameters
    ----------
    train
        The train.
    rail
        The rail's receptances, standing or moving, at least at the train's axle distances.
    frequency
        Frequencies of excitation, Hz, (n,), positive.

    Returns
    -------
    ndarray of complex, shape (n, axles, axles)
        G_lp = P_l for w̃_p = 1 and no unevenness elsewhere, N/m; axles ascend in x.
    """
    return AxleEquations(train, rail, frequency).matrices(slice(None))


def axle_forces(train: Train, rail: Receptances, frequency: np.ndarray, unevenness: np.ndarray) -> np.ndarray:
    """Return the forces at all axles for a given unevenness under each.

    Parameters
    ----------
    train, rail, frequency
        As in `force_matrices`.
    unevenness
        w̃_l, m, complex (n, axles).

    Returns
    -------
    ndarray of complex, shape (n, axles)
        P_l, N; axles ascend in x.
    """
    return AxleEquations(train, rail, frequency).forces(slice(None), unevenness[..., None])[..., 0]


class AxleEquations:
    """Eq. 12 at some frequencies, solved for some of them at a time.

    Parameters
    ----------
    train, rail, frequency
        As for `force_matrices`.
    """

    def __init__(self, train: Train, rail: Receptances, frequency: np.ndarray) -> None:
        self._train = train
        self._layout = _layout(train)
        self._column = np.searchsorted(rail.distance, self._layout.distance - 1e-8)
        with cost.stage("wheel-rail forces"):
            self._omega = 2.0 * np.pi * frequency
            self._receptance = rail.at(frequency)

    def matrices(self, rows: slice) -> np.ndarray:
        """Return the forces per unit unevenness at each axle, as `force_matrices`, at some frequencies."""
        unit = np.eye(self._train.axle_count, dtype=complex)
        return self.forces(rows, np.broadcast_to(unit, (self._omega[rows].size, *unit.shape)))

    def forces(self, rows: slice, unevenness: np.ndarray) -> np.ndarray:
        """Return the forces for several sets of unevenness at some of the frequencies, (n, axles, sets)."""
        forces = np.empty(unevenness.shape, complex)
        with cost.stage("wheel-rail forces") as spent:
            receptance = self._receptance[rows]
            flexibility = [block.flexibilities(self._omega[rows]) for block in self._layout.kinds]
            growth = solve(
                receptance,
                self._column,
                np.concatenate(flexibility),
                self._layout.first_term,
                self._layout.term,
                self._layout.share,
                self._layout.contact,
                np.ascontiguousarray(unevenness),
                forces,
            )
            for row in np.flatnonzero(~(growth < _MOST_GROWTH)):  # no train so far has needed it
                omega = self._omega[rows][row]
                compliance = receptance[row][self._column] + train_receptance(self._train, omega)
                compliance += np.diag(self._layout.contact)
                forces[row] = -np.linalg.solve(compliance, unevenness[row])
            spent.evaluations += len(forces)
        return forces


class _Layout(NamedTuple):
    """The properties of a train that its axles' equations need."""

    distance: np.ndarray
    """Distance between every two axles, signed, m, (axles, axles)."""
    kinds: tuple[Block, ...]
    """Its blocks, each once; their flexibilities, one block after the other, are the terms."""
    first_term: np.ndarray
    """Where the terms between every two axles begin, row by row, and where the last ones end."""
    term: np.ndarray
    """Which terms these are."""
    share: np.ndarray
    """What of each counts between the two axles."""
    contact: np.ndarray
    """1/k_H of every axle, m/N."""


@lru_cache(16)
def _layout(train: Train) -> _Layout:
    alpha = train.axle_positions
    kinds = tuple(dict.fromkeys(train.blocks))
    starts = np.cumsum([0] + [len(block.shapes) for block in kinds])
    between: list[list[tuple[int, float]]] = [[] for _ in range(alpha.size**2)]
    axle = 0
    for block in reversed(train.blocks):
        start = int(starts[kinds.index(block)])
        shapes = block.shapes
        for term, row, column in zip(*np.nonzero(shapes), strict=True):
            pair = (axle + row) * alpha.size + axle + column
            between[pair].append((start + int(term), float(shapes[term, row, column])))
        axle += block.axle_count
    return _Layout(
        np.round(alpha[:, None] - alpha[None, :], 9),
        kinds,
        np.cumsum([0] + [len(terms) for terms in between]),
        np.array([term for terms in between for term, _share in terms]),
        np.array([share for terms in between for _term, share in terms]),
        1.0 / train.contact_stiffness,
    )


def axle_phases(train: Train, frequency: np.ndarray, speed: float) -> np.ndarray:
    """Return w̃_l = e^{iβα_l} with β = ω/v (Eq. 20, 21), shape (frequencies, axles)."""
    return phasors(2.0 * np.pi / speed * frequency[:, None] * train.axle_positions)


def axle_numbers(train: Train) -> np.ndarray:
    """Return the axles' numbers in results, ascending in x: axle 1 leads the train."""
    return np.arange(train.axle_count, 0, -1)
