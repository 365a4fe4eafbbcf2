"""Amplitudes of a passage by the full model.

    U_nj = (Δf/v) H̃(β_n − 2πf_j/v, y, f_j) A(β_n, f_j) i2πf_j √Δβ_n,        A = Σ_l q_l(β_n) e^{2πi f_j α_l/v}

with q_l of `railvib.psd.excitation`; at −β_n the q_l are conjugate.
"""

from collections.abc import Mapping

import numpy as np

from railvib.parameters.receiver import Receiver
from railvib.passage.amplitudes import Block, Response, line_phases, time_shift, trimmed
from railvib.passage.grid import Grid
from railvib.transfer.transfer_function import TransferFunction


def full_model_amplitudes(
    receivers: Mapping[Receiver, TransferFunction],
    amplitude: np.ndarray,
    axle_position: np.ndarray,
    train_length: float,
    speed: float,
    grid: Grid,
    lines_at_once: int,
) -> dict[Receiver, list[Block]]:
    """Return the amplitudes of velocity at some receivers.

    Parameters
    ----------
    receivers
        The receivers' transfer functions, taken some at a time.
    amplitude
        q_l of every set of unevenness at the grid's wavenumbers, N/√(rad/m), complex (sets, n, axles).
    axle_position
        α, m, (axles,).
    train_length, speed
        m, m/s.
    grid
        Lines and wavenumbers.
    lines_at_once
        Lines of a block.
    """
    weighted = amplitude * np.sqrt(grid.width)[:, None]
    position = axle_position + time_shift(grid, train_length, speed)
    beta = grid.wavenumber
    amplitudes: dict[Receiver, list[Block]] = {receiver: [] for receiver in receivers}
    for receiver, function in receivers.items():
        for start in range(0, grid.frequency.size, lines_at_once):
            f = grid.frequency[start : start + lines_at_once]
            phase = line_phases(f, position, speed) * (2j * np.pi * f * grid.step / speed)[:, None]
            shift = 2.0 * np.pi * f / speed
            parts = Response.of(function, f)
            reach = max(response.reach for _lines, response in parts)
            for sign in (1.0, -1.0):
                # |±β − shift| < reach
                low, high = (shift[0] - reach, shift[-1] + reach) if sign > 0.0 else (0.0, reach - shift[0])
                first, last = np.searchsorted(beta, [low, high])
                if first == last:
                    continue
                rows = slice(first, last)
                transfer = np.empty((f.size, last - first), complex)
                for lines, response in parts:
                    transfer[lines] = response.at(sign * beta[rows] - shift[lines, None])
                for number, each in enumerate(weighted):
                    q = each[rows] if sign > 0.0 else each[rows].conj()
                    value = (q @ phase.T) * transfer.T
                    block = trimmed(Block(int(first), start, value, sign < 0.0, number))
                    if block is not None:
                        amplitudes[receiver].append(block)
    return amplitudes
