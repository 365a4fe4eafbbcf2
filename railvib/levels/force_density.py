"""Force density and line-source transfer mobility, as the FTA's guidance uses them: L_v = L_F + TM_L.

Both are sums of energy. There are two force densities: the theoretical one, from the forces of the axles, and
that of the guidance, L_v − TM_L at one receiver, which is then used at other receivers and on other soils.
Only the sum of both parts can be compared between sources: impacts on the rail and beside the track give
different parts.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railvib.levels import references
from railvib.levels.references import level

FORCE_DENSITY_OFFSET = float(level(references.FORCE_DENSITY_US**2, references.FORCE_DENSITY))
"""dB: a force density re 1 N/√m less that re 1 lb/√ft."""
LINE_MOBILITY_OFFSET = float(level(references.LINE_MOBILITY_US**2, references.LINE_MOBILITY))
"""dB: a line-source mobility re 1e-9 (m/s)/(N/√m) less that re 1e-6 (in/s)/(lb/√ft)."""


def line_mobility_of_impacts(point_mobility_level: ArrayLike, spacing: float) -> NDArray[np.float64]:
    """Return the level of line-source mobility from point-source mobilities along a train.

    Parameters
    ----------
    point_mobility_level
        20 lg of |v/F| at impacts from one end of the train to the other, dB, (impacts, ...).
    spacing
        Distance between the impacts, in the unit of length of the result.

    Returns
    -------
    ndarray, shape (...)
        10 lg of the trapezoidal sum of energies, dB.
    """
    energy = 10.0 ** (np.asarray(point_mobility_level, dtype=np.float64) / 10.0)
    return np.asarray(10.0 * np.log10(np.trapezoid(energy, dx=spacing, axis=0)))


def force_density_level(
    force_mean_square: ArrayLike, train_length: float, reference: float = references.FORCE_DENSITY
) -> NDArray[np.float64]:
    """Return the theoretical force density 10 lg Σ_l P_l²/L in bands, dB (Verbraken et al. 2011).

    Parameters
    ----------
    force_mean_square
        Mean squares of the axles' forces, N², (axles, bands).
    train_length
        L, m.
    reference
        N/√m.
    """
    return level(np.sum(force_mean_square, axis=0) / train_length, reference)
