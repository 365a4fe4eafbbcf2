"""The quasi-static part of a passage: the history of the axle loads, which no unevenness changes.

m(t) = Re Σ_j M_j e^{2πi f_j t},        M_j = 2 (Δf/v) H̃(2πf_j/v, y, f_j) i2πf_j Σ_l F_l e^{2πi f_j α_l/v}
"""

import numpy as np

from railvib.passage.amplitudes import line_phases
from railvib.passage.grid import Grid
from railvib.transfer.transfer_function import TransferFunction


def quasi_static_amplitudes(
    function: TransferFunction, axle_load: np.ndarray, position: np.ndarray, speed: float, grid: Grid
) -> np.ndarray:
    """Return the amplitudes of velocity M_j, complex (lines,), m/s.

    Parameters
    ----------
    function
        The receiver's transfer function.
    axle_load
        N, (axles,).
    position
        Axles with the time shift of the record, m, (axles,), see `railvib.passage.amplitudes.time_shift`.
    speed
        m/s.
    grid
        Lines.
    """
    f = grid.frequency
    load = line_phases(f, position, speed) @ axle_load
    transfer = function.along(f, 2.0 * np.pi * f / speed)
    return np.asarray(4j * np.pi * f * grid.step / speed * transfer * load)
