"""The full model: the train moves, and a fixed receiver hears many excitation frequencies at once.

A load P e^{iωt} at α_l + vt has at a fixed point the spectrum S_0 = (1/v) H̃(κ, y, 2πf) e^{iκx} Σ_l P_l(ω)
e^{−iκα_l} with κ = (ω − 2πf)/v: no inverse transform, only H̃ at the
receiving frequency, over wavenumber. With β = ω/v = κ + 2πf/v and

    q_l(β) = P_l(βv) e^{−iβα_l} √S_w(|β|),        A(β, f) = Σ_l q_l(β) e^{2πifα_l/v}

the response is S(f) = (1/(T v²)) ∫ |H̃(κ, f)|² |A(κ + 2πf/v, f)|² dκ over all κ (Eq. 29). The q_l are smooth,
because the phases of the forces are taken out, and are computed once on a grid of β for every receiving
frequency.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numba
import numpy as np

from railvib import blocks, cost
from railvib.forces import arrivals, force_matrices
from railvib.panels import BARYCENTRIC, NODE, ORDER, WEIGHT, lagrange_weights
from railvib.receptance import Receptances
from railvib.transfer import Receiver, TransferFunction
from railvib.unevenness import Unevenness
from railvib.vehicle import Train

_FINE_HZ = 0.025
_FINE_UP_TO_HZ = 4.0
_COARSE_HZ = 0.1
_LOWEST_HZ = 0.005
_LINES_AT_ONCE = 64
_SHORTEST_PART, _LONGEST_PART = 12.0, 60.0
"""Bounds of a part of a panel, in steps of the fine and of the coarse grid; it has twelve nodes."""
_NEGLIGIBLE = 1e-16
"""Share of ∫ |H̃|² below which a panel is passed over: no excitation is stronger than another by that much."""


@dataclass(frozen=True)
class Excitation:
    """q_l(β) on two uniform grids of β that join: fine over the vehicles' own frequencies, coarser above."""

    step: tuple[float, float]
    """Steps of both grids, rad/m."""
    joint: int
    """Points of the fine grid; the coarse one starts at its last."""
    amplitude: np.ndarray
    """q_l, N/√(rad/m), complex (β, axles)."""
    axle_position: np.ndarray
    """α, m, (axles,)."""
    wavenumbers: tuple[float, float] = (0.0, np.inf)
    """Where the unevenness is cut off, lowest and highest β, rad/m; the amplitudes go on beyond, smoothly."""


def excitation(
    train: Train,
    moving: Receptances,
    unevenness: Unevenness,
    speed: float,
    maximum_frequency: float,
    refinement: int = 1,
) -> Excitation:
    """Return the forces of the full model over the wavenumber of the unevenness.

    Parameters
    ----------
    train, unevenness
        The train and the rails' unevenness.
    moving
        The rail's receptances at the train's speed.
    speed
        m/s.
    maximum_frequency
        Highest frequency of excitation, Hz.
    refinement
        Factor by which the grids are finer than usual.
    """
    span = float(np.ptp(train.axle_positions))
    per_hz = 2.0 * np.pi / speed
    fine = min(_FINE_HZ * per_hz, 0.25 / span) / refinement
    coarse = min(_COARSE_HZ * per_hz, 1.0 / span) / refinement
    joint = int(np.ceil(_FINE_UP_TO_HZ * per_hz / fine)) + 1
    first = fine * np.arange(joint)
    count = int(np.ceil((maximum_frequency * per_hz - first[-1]) / coarse))
    beta = np.concatenate([first, first[-1] + coarse * np.arange(1, max(count, 8) + 1)])
    frequency = np.maximum(beta / per_hz, _LOWEST_HZ)
    phase = arrivals(train, frequency, speed)
    force = np.einsum("flp,fp->fl", force_matrices(train, moving, frequency), phase)
    amplitude = force * phase.conj() * np.sqrt(unevenness.uncut.psd(frequency * per_hz))[:, None]
    shortest, longest = unevenness.cut_offs
    ends = (2.0 * np.pi / longest, 2.0 * np.pi / shortest if shortest > 0.0 else np.inf)
    return Excitation((fine, coarse), joint, amplitude, train.axle_positions, ends)


def passage_spectra(
    receivers: Mapping[Receiver, TransferFunction],
    excited: Excitation,
    train_length: float,
    speed: float,
    frequency: np.ndarray,
) -> dict[Receiver, np.ndarray]:
    """Return PSDs of displacement at fixed points, averaged over the passage (Eq. 29 over T).

    Parameters
    ----------
    receivers
        The receivers' tabulated transfer functions.
    excited
        The forces, from `excitation`.
    train_length
        L, m; the passage takes T = L/v.
    speed
        m/s.
    frequency
        Receiving frequencies, Hz, (n,).

    Returns
    -------
    dict of ndarray, shape (n,)
        One-sided PSDs, m²/Hz.
    """
    psd = {receiver: np.empty(frequency.size) for receiver in receivers}
    with cost.stage("passage") as spent:
        for start in range(0, frequency.size, _LINES_AT_ONCE):
            here = np.arange(start, min(start + _LINES_AT_ONCE, frequency.size))
            turn = np.exp(2j * np.pi / speed * frequency[here, None] * excited.axle_position)
            ahead = turn @ excited.amplitude.T
            behind = turn @ excited.amplitude.conj().T
            for receiver, transfer in receivers.items():
                which = blocks.assigned(frequency[here], transfer.blocks)
                for block in np.unique(which):
                    own = np.flatnonzero(which == block)
                    f = frequency[here[own]]
                    table = transfer.blocks[int(block)]
                    _beta, value = transfer.at(int(block), f)
                    psd[receiver][here[own]] = _wavenumber_integrals(
                        table.nodes.panel_edges(f),
                        value,
                        2.0 * np.pi * f / speed,
                        ahead[own],
                        behind[own],
                        excited.step[0],
                        excited.step[1],
                        excited.joint,
                        *excited.wavenumbers,
                    )
                    spent.evaluations += 2 * value.size
                    spent.kernel_calls += 1
    return {receiver: each / (train_length * speed) for receiver, each in psd.items()}


@numba.njit(cache=True, error_model="numpy")
def _amplitude(beta, ahead, behind, fine, coarse, joint, weight):
    """Return |A(β)|² from its values on the two joined grids; ahead for β ≥ 0, behind for −β."""
    row = ahead if beta >= 0.0 else behind
    b = abs(beta)
    last = fine * (joint - 1)
    if b < last:
        at = b / fine
        low = 0
        high = joint
    else:
        at = (b - last) / coarse + joint - 1
        low = joint - 1
        high = row.shape[0]
    if at > row.shape[0] - 1:
        return 0.0
    first = min(max(int(np.floor(at)) - 3, low), high - 8)
    t = at - first
    lagrange_weights(t, weight)
    value = 0j
    for m in range(8):
        value += weight[m] * row[first + m]
    return value.real * value.real + value.imag * value.imag


@numba.njit(cache=True, error_model="numpy")
def _part_end(start, high, side, shift, shortest, longest, lowest, highest):
    """Return where a part of a panel ends that starts at |κ| = start.

    A part is short against β near β = 0, where the vehicles' own resonances lie, and against the axles'
    distances everywhere; and it ends where β = side·|κ| + shift changes sign or the unevenness is cut off.
    """
    length = min(max(0.5 * abs(side * start + shift), shortest), longest)
    end = high if high - start < 1.1 * length else start + length
    for mark in (0.0, lowest, -lowest, highest, -highest):
        at = side * (mark - shift)
        if start * (1.0 + 1e-12) < at < end:
            end = at
    return end


@numba.njit(cache=True, error_model="numpy")
def _wavenumber_integrals(edge, transfer, shift, ahead, behind, fine, coarse, joint, lowest, highest):
    """Return ∫ |H̃(κ)|² |A(κ + shift)|² dκ over lowest ≤ |κ + shift| ≤ highest for every line."""
    lagrange = np.empty(8)
    size = np.empty(edge.shape[1] - 1)
    out = np.zeros(edge.shape[0])
    shortest = _SHORTEST_PART * fine
    longest = _LONGEST_PART * coarse
    for i in range(edge.shape[0]):
        total = 0.0
        for p in range(edge.shape[1] - 1):
            low = edge[i, p]
            high = edge[i, p + 1]
            size[p] = 0.0
            for j in range(ORDER):
                h = transfer[i, p * ORDER + j]
                size[p] = max(size[p], (high - low) * (h.real * h.real + h.imag * h.imag))
        negligible = _NEGLIGIBLE * size.sum()
        for p in range(edge.shape[1] - 1):
            if size[p] < negligible:
                continue
            low = edge[i, p]
            high = edge[i, p + 1]
            middle = 0.5 * (low + high)
            half = 0.5 * (high - low)
            for side in (-1.0, 1.0):
                start = low
                while start < high * (1.0 - 1e-12):
                    end = _part_end(start, high, side, shift[i], shortest, longest, lowest, highest)
                    beta = abs(0.5 * side * (start + end) + shift[i])
                    if beta < lowest or beta > highest:
                        start = end
                        continue
                    own = start == low and end == high
                    for j in range(ORDER):
                        kappa = 0.5 * (start + end) + 0.5 * (end - start) * NODE[j]
                        if own:
                            h = transfer[i, p * ORDER + j]
                        else:
                            x = (kappa - middle) / half
                            numerator = 0j
                            denominator = 0.0
                            for k in range(ORDER):
                                d = x - NODE[k]
                                if d == 0.0:
                                    d = 1e-300
                                w = BARYCENTRIC[k] / d
                                numerator += w * transfer[i, p * ORDER + k]
                                denominator += w
                            h = numerator / denominator
                        squared = h.real * h.real + h.imag * h.imag
                        a = _amplitude(
                            side * kappa + shift[i], ahead[i], behind[i], fine, coarse, joint, lagrange
                        )
                        total += 0.5 * (end - start) * WEIGHT[j] * squared * a
                    start = end
        out[i] = total
    return out


def quasi_static_spectrum(
    receiver: TransferFunction, train: Train, speed: float, frequency: np.ndarray
) -> np.ndarray:
    """Return the PSD of displacement at a fixed point from the moving axle loads: |S_0(f; 0)|²·2/T.

    Parameters
    ----------
    receiver
        The receiver's tabulated transfer function.
    train
        The train.
    speed
        m/s.
    frequency
        Receiving frequencies, Hz, (n,).

    Returns
    -------
    ndarray, shape (n,)
        One-sided PSD, m²/Hz.
    """
    kappa = 2.0 * np.pi * frequency / speed
    with cost.stage("quasi-static") as spent:
        transfer = receiver.along(frequency, kappa)
        load = np.exp(1j * kappa[:, None] * train.axle_positions) @ train.axle_loads
        spent.evaluations += frequency.size
    return np.asarray(np.abs(transfer * load / speed) ** 2 * 2.0 * speed / train.length)
