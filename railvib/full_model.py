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
from functools import cached_property

import numba
import numpy as np

from railvib import cost, threads
from railvib.forces import arrivals, axle_forces
from railvib.panels import BARYCENTRIC, NODE, ORDER, WEIGHT
from railvib.receptance import Receptances
from railvib.transfer import Receiver, TransferFunction, same_nodes, together
from railvib.unevenness import Unevenness
from railvib.vehicle import Train

_FINE_HZ = 0.025
_FINE_UP_TO_HZ = 4.0
_COARSE_HZ = 0.1
_LOWEST_HZ = 0.005
_LINES_AT_ONCE = 64
_SHORTEST_PART, _LONGEST_PART = 12.0, 60.0
"""Bounds of a part of a panel, in steps of the fine and of the coarse grid; it has twelve nodes."""
_MOST_PARTS = 64
"""Parts of panels that are gathered before the excitation is interpolated for all of them."""
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

    @cached_property
    def _both_sides(self) -> np.ndarray:
        """q_l at −β, its conjugate, from the far end to zero, then at β: real parts over imaginary ones."""
        both = np.concatenate([self.amplitude[::-1].conj(), self.amplitude]).T
        return np.concatenate([both.real, both.imag])

    def turned(self, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return real and imaginary part of A = Σ_l phase_l q_l from −β to β, for phases (lines, axles)."""
        with threads.single():
            real = np.concatenate([phase.real, -phase.imag], axis=1) @ self._both_sides
            imag = np.concatenate([phase.imag, phase.real], axis=1) @ self._both_sides
        return real, imag


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
    force = axle_forces(train, moving, frequency, phase)
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
            real, imag = excited.turned(turn)
            for members, block, own in same_nodes(receivers, frequency[here]):
                f = frequency[here[own]]
                value = together([receivers[each] for each in members], block, f)
                integrals = _wavenumber_integrals(
                    receivers[members[0]].blocks[block].nodes.panel_edges(f),
                    value,
                    2.0 * np.pi * f / speed,
                    real[own],
                    imag[own],
                    excited.step[0],
                    excited.step[1],
                    excited.joint,
                    *excited.wavenumbers,
                )
                for receiver, integral in zip(members, integrals.T, strict=True):
                    psd[receiver][here[own]] = integral
                spent.evaluations += 2 * value.size
                spent.kernel_calls += 1
    return {receiver: each / (train_length * speed) for receiver, each in psd.items()}


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _squared_amplitudes(beta, count, real, imag, fine, coarse, joint, out, first, weight):
    """Write |A(β)|² at `count` places β of either sign to `out`, interpolated from the two joined grids.

    `real` and `imag` hold A at −β, descending to zero, then at β, ascending; `first` and `weight` are room to
    work in.
    """
    points = real.shape[0] // 2
    last = fine * (joint - 1)
    for i in range(count):
        b = abs(beta[i])
        near = b < last
        at = b / fine if near else (b - last) / coarse + (joint - 1)
        low = 0 if near else joint - 1
        high = (joint if near else points) - 8
        n = min(max(int(at) - 3, low), high)
        t = at - n
        # Beyond the grids there is no excitation.
        scale = 1.0 if at <= points - 1 else 0.0
        a01 = t * (t - 1.0)
        a23 = (t - 2.0) * (t - 3.0)
        a45 = (t - 4.0) * (t - 5.0)
        a67 = (t - 6.0) * (t - 7.0)
        below = scale * a01 * a23
        above = scale * a45 * a67
        weight[0, i] = -(t - 1.0) * a23 * above / 5040.0
        weight[1, i] = t * a23 * above / 720.0
        weight[2, i] = -a01 * (t - 3.0) * above / 240.0
        weight[3, i] = a01 * (t - 2.0) * above / 144.0
        weight[4, i] = -below * (t - 5.0) * a67 / 144.0
        weight[5, i] = below * (t - 4.0) * a67 / 240.0
        weight[6, i] = -below * a45 * (t - 7.0) / 720.0
        weight[7, i] = below * a45 * (t - 6.0) / 5040.0
        first[i] = n
    for i in range(count):
        re = 0.0
        im = 0.0
        if beta[i] >= 0.0:
            n = points + first[i]
            for m in range(8):
                re += weight[m, i] * real[n + m]
                im += weight[m, i] * imag[n + m]
        else:
            n = points - 1 - first[i]
            for m in range(8):
                re += weight[m, i] * real[n - m]
                im += weight[m, i] * imag[n - m]
        out[i] = re * re + im * im


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


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _wavenumber_integrals(edge, transfer, shift, real, imag, fine, coarse, joint, lowest, highest):
    """Return ∫ |H̃(κ)|² |A(κ + shift)|² dκ over lowest ≤ |κ + shift| ≤ highest, (lines, receivers).

    `transfer` is (receivers, lines, nodes). The excitation is found once for all receivers.
    """
    receivers, lines, nodes = transfer.shape
    panels = nodes // ORDER
    out = np.zeros((lines, receivers))
    shortest = _SHORTEST_PART * fine
    longest = _LONGEST_PART * coarse
    most = ORDER * _MOST_PARTS
    beta = np.empty(most)
    factor = np.empty(most)
    squared = np.empty(most)
    first = np.empty(most, np.int64)
    weight = np.empty((8, most))
    panel = np.empty(_MOST_PARTS, np.int64)
    whole = np.empty(_MOST_PARTS, np.bool_)
    offset = np.empty(most)
    values = np.empty((3, ORDER))
    power = np.empty((receivers, nodes))
    needed = np.empty(panels, np.bool_)
    for i in range(lines):
        own = transfer[:, i]
        needed[:] = False
        for q in range(receivers):
            for j in range(nodes):
                h = own[q, j]
                power[q, j] = h.real * h.real + h.imag * h.imag
            _mark_needed(edge[i], power[q], needed)
        parts = 0
        for p in range(panels):
            if not needed[p]:
                continue
            low = edge[i, p]
            high = edge[i, p + 1]
            for side in (-1.0, 1.0):
                start = low
                while start < high * (1.0 - 1e-12):
                    end = _part_end(start, high, side, shift[i], shortest, longest, lowest, highest)
                    centre = 0.5 * (start + end)
                    half = 0.5 * (end - start)
                    if lowest <= abs(side * centre + shift[i]) <= highest:
                        for j in range(ORDER):
                            n = parts * ORDER + j
                            kappa = centre + half * NODE[j]
                            beta[n] = side * kappa + shift[i]
                            factor[n] = half * WEIGHT[j]
                            offset[n] = (2.0 * kappa - low - high) / (high - low)
                        panel[parts] = p
                        whole[parts] = start == low and end == high
                        parts += 1
                    start = end
                    if parts == _MOST_PARTS:
                        _squared_amplitudes(
                            beta, parts * ORDER, real[i], imag[i], fine, coarse, joint, squared, first, weight
                        )
                        _add_parts(parts, panel, whole, offset, factor, squared, power, own, values, out[i])
                        parts = 0
        _squared_amplitudes(
            beta, parts * ORDER, real[i], imag[i], fine, coarse, joint, squared, first, weight
        )
        _add_parts(parts, panel, whole, offset, factor, squared, power, own, values, out[i])
    return out


@numba.njit(cache=True, error_model="numpy")
def _mark_needed(edge, power, needed):
    """Mark the panels in which a receiver has more than a negligible share of ∫ |H̃|² dκ."""
    total = 0.0
    for p in range(needed.shape[0]):
        for j in range(ORDER):
            total += (edge[p + 1] - edge[p]) * power[p * ORDER + j] / ORDER
    for p in range(needed.shape[0]):
        largest = 0.0
        for j in range(ORDER):
            largest = max(largest, power[p * ORDER + j])
        if (edge[p + 1] - edge[p]) * largest >= _NEGLIGIBLE * total:
            needed[p] = True


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "reassoc"})
def _add_parts(parts, panel, whole, offset, factor, squared, power, transfer, values, out):
    """Add the integrals over some parts of panels to every receiver's sum; `values` is room to work in."""
    receivers = power.shape[0]
    for part in range(parts):
        at = part * ORDER
        node = panel[part] * ORDER
        if whole[part]:
            for q in range(receivers):
                total = 0.0
                for j in range(ORDER):
                    total += factor[at + j] * squared[at + j] * power[q, node + j]
                out[q] += total
            continue
        # Barycentric interpolation from the panel's nodes, all points of the part at once.
        below = values[0]
        for q in range(receivers):
            real = values[1]
            imag = values[2]
            for j in range(ORDER):
                below[j] = 0.0
                real[j] = 0.0
                imag[j] = 0.0
            for k in range(ORDER):
                h = transfer[q, node + k]
                for j in range(ORDER):
                    away = offset[at + j] - NODE[k]
                    basis = BARYCENTRIC[k] / (away if away != 0.0 else 1e-290)
                    below[j] += basis
                    real[j] += basis * h.real
                    imag[j] += basis * h.imag
            total = 0.0
            for j in range(ORDER):
                real_part = real[j] / below[j]
                imag_part = imag[j] / below[j]
                total += factor[at + j] * squared[at + j] * (real_part * real_part + imag_part * imag_part)
            out[q] += total


def quasi_static_spectra(
    receivers: Mapping[Receiver, TransferFunction], train: Train, speed: float, frequency: np.ndarray
) -> dict[Receiver, np.ndarray]:
    """Return PSDs of displacement at fixed points from the moving axle loads: |S_0(f; 0)|²·2/T.

    Parameters
    ----------
    receivers
        The receivers' tabulated transfer functions.
    train
        The train.
    speed
        m/s.
    frequency
        Receiving frequencies, Hz, (n,).

    Returns
    -------
    dict of ndarray, shape (n,)
        One-sided PSDs, m²/Hz.
    """
    kappa = 2.0 * np.pi * frequency / speed
    with cost.stage("quasi-static") as spent:
        load = np.exp(1j * kappa[:, None] * train.axle_positions) @ train.axle_loads / speed
        psd = {
            receiver: np.abs(transfer.along(frequency, kappa) * load) ** 2 * 2.0 * speed / train.length
            for receiver, transfer in receivers.items()
        }
        spent.evaluations += frequency.size * len(receivers)
    return psd
