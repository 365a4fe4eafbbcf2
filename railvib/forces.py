"""Wheel–rail forces of a train on uneven rails.

    [Σ_T + Σ_R + I/k_H] P = −w̃        (Eq. 12)

With the standing receptances of the rail this is the moving-roughness approach, with the moving ones the full
model; nothing else differs.
"""

import numpy as np

from railvib import cost
from railvib.receptance import Receptances
from railvib.vehicle import Train, train_receptance

_AT_ONCE = 128
"""Frequencies whose matrices are set up together: few enough to stay in the cache."""


def axle_distances(train: Train) -> np.ndarray:
    """Return the distinct signed distances α_j − α_k between axles, ascending, m."""
    alpha = train.axle_positions
    return np.unique(np.round(alpha[:, None] - alpha[None, :], 9))


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
    with cost.stage("wheel-rail forces") as spent:
        forces = -np.linalg.inv(_compliances(train, rail, frequency))
        spent.evaluations += frequency.size
    return np.asarray(forces)


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
    forces = np.empty(unevenness.shape, complex)
    with cost.stage("wheel-rail forces") as spent:
        for start in range(0, frequency.size, _AT_ONCE):
            here = slice(start, start + _AT_ONCE)
            matrices = _compliances(train, rail, frequency[here])
            forces[here] = -np.linalg.solve(matrices, unevenness[here, :, None])[..., 0]
        spent.evaluations += frequency.size
    return forces


def _compliances(train: Train, rail: Receptances, frequency: np.ndarray) -> np.ndarray:
    """Return Σ_T + Σ_R + I/k_H, (n, axles, axles), m/N."""
    alpha = train.axle_positions
    column = np.searchsorted(rail.distance, np.round(alpha[:, None] - alpha[None, :], 9) - 1e-8)
    compliance = rail.at(frequency)[:, column]
    compliance += train_receptance(train, 2.0 * np.pi * frequency)
    compliance += np.diag(1.0 / train.contact_stiffness)
    return np.asarray(compliance)


def arrivals(train: Train, frequency: np.ndarray, speed: float) -> np.ndarray:
    """Return w̃_l = e^{iβα_l} with β = ω/v (Eq. 20, 21), shape (frequencies, axles)."""
    return np.asarray(np.exp(2j * np.pi / speed * frequency[:, None] * train.axle_positions))


def axle_numbers(train: Train) -> np.ndarray:
    """Return the axles' numbers in results, ascending in x: axle 1 leads the train."""
    return np.arange(train.axle_count, 0, -1)
