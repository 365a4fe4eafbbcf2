"""The full model: the train moves, and a fixed receiver hears many excitation frequencies at once.

A load P e^{iωt} at α_l + vt has at a fixed point the spectrum S_0 = (1/v) H̃(κ, y, 2πf) e^{iκx} Σ_l P_l(ω)
e^{−iκα_l} with κ = (ω − 2πf)/v: no inverse transform, only H̃ at the
receiving frequency, over wavenumber. With β = ω/v = κ + 2πf/v and

    q_l(β) = P_l(βv) e^{−iβα_l} √S_w(|β|),        A(β, f) = Σ_l q_l(β) e^{2πifα_l/v}

the response is S(f) = (1/(T v²)) ∫ |H̃(κ, f)|² |A(κ + 2πf/v, f)|² dκ over all κ (Eq. 29). The q_l are smooth,
because the phases of the forces are taken out, and are computed once for every receiving frequency, by
`railvib.excitation`.
"""

from collections.abc import Mapping

import numba
import numpy as np

from railvib import cost
from railvib.excitation import Excitation
from railvib.panels import DOWNWARD, NODE, ORDER, UPWARD, WEIGHT, count_below, to_legendre
from railvib.transfer import Receiver, TransferFunction, same_nodes, together
from railvib.vehicle import Train

_LINES_AT_ONCE = 64
_PARTS = 32
"""Parts of panels that are gathered before they are integrated over together, in vector registers."""
_NEGLIGIBLE = 1e-16
"""Share of ∫ |H̃|² below which a panel is passed over: no excitation is stronger than another by that much."""


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
            parts = excited.turned(turn)
            for members, block, own in same_nodes(receivers, frequency[here]):
                f = frequency[here[own]]
                value = together([receivers[each] for each in members], block, f)
                on_panels = value.reshape(*value.shape[:2], -1, ORDER)
                integrals = _wavenumber_integrals(
                    receivers[members[0]].blocks[block].nodes.panel_edges(f),
                    to_legendre(on_panels).view(float),
                    2.0 * np.pi * f / speed,
                    parts,
                    own,
                    excited.edge,
                    *excited.wavenumbers,
                )
                for receiver, integral in zip(members, integrals.T, strict=True):
                    psd[receiver][here[own]] = integral
                spent.evaluations += 2 * value.size
                spent.kernel_calls += 1
    return {receiver: each / (train_length * speed) for receiver, each in psd.items()}


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _wavenumber_integrals(edge, transfer, shift, parts, rows, beta_edge, lowest, highest):
    """Return ∫ |H̃(κ)|² |A(κ + shift)|² dκ over lowest ≤ |κ + shift| ≤ highest, (lines, receivers).

    Panels of κ and those of β cut each other into parts with nodes of their own. `transfer` holds the
    Legendre series of H̃, (receivers, lines, panels, 2·order), real and imaginary parts in turn; `rows` tells
    which lines of `parts`, from `Excitation.turned`, these are.
    """
    receivers, lines, panels, _ = transfer.shape
    out = np.zeros((lines, receivers))
    tiny = 1e-12 * beta_edge[-1]
    terms = parts.shape[3]
    amplitude = np.empty((2, 2 * terms))
    needed = np.empty((receivers, panels), np.bool_)
    share = np.empty(panels)
    line = np.empty(_PARTS, np.int64)
    place = np.zeros((5, _PARTS))
    series = np.zeros((1 + receivers, 2 * ORDER, _PARTS))
    squares = np.empty((2 + receivers, _PARTS))
    count = 0
    for i in range(lines):
        _amplitudes(parts, rows[i], amplitude)
        _mark_needed(edge[i], transfer[:, i], share, needed)
        for p in range(panels):
            wanted = False
            for q in range(receivers):
                wanted |= needed[q, p]
            if not wanted:
                continue
            low = edge[i, p]
            high = edge[i, p + 1]
            for side in (-1.0, 1.0):
                start = low
                while high - start > tiny:
                    b, backward, end = _excited_panel(beta_edge, start, side, shift[i], tiny)
                    if b >= beta_edge.shape[0] - 1:
                        start = end  # beyond the last edge there is no excitation
                        continue
                    if end > high - tiny:
                        end = high
                    centre = 0.5 * (start + end)
                    half = 0.5 * (end - start)
                    start = end
                    beta = side * centre + shift[i]
                    if not lowest <= abs(beta) <= highest:
                        continue
                    # Where the part's nodes lie on the panels of β and of κ: offset and slope.
                    scale = 2.0 / (beta_edge[b + 1] - beta_edge[b])
                    place[0, count] = (abs(beta) - beta_edge[b]) * scale - 1.0
                    place[1, count] = (-side if backward else side) * half * scale
                    place[2, count] = 2.0 * (centre - low) / (high - low) - 1.0
                    place[3, count] = 2.0 * half / (high - low)
                    place[4, count] = half
                    first = b * ORDER + (terms if backward else 0)
                    for n in range(ORDER):
                        series[0, 2 * n, count] = amplitude[0, first + n]
                        series[0, 2 * n + 1, count] = amplitude[1, first + n]
                    for q in range(receivers):
                        # Nothing where another receiver alone needs the panel: none depends on the others.
                        for n in range(2 * ORDER):
                            series[1 + q, n, count] = transfer[q, i, p, n] if needed[q, p] else 0.0
                    line[count] = i
                    count += 1
                    if count == _PARTS:
                        _add_parts(count, place, series, squares, line, out)
                        count = 0
    _add_parts(count, place, series, squares, line, out)
    return out


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _add_parts(count, place, series, squares, line, out):
    """Add the integrals over some parts to the sums of their lines; `squares` is room to work in.

    All places are computed, whatever the count, so that each goes through the same vector instructions.
    """
    receivers = series.shape[0] - 1
    for q in range(receivers):
        for m in range(_PARTS):
            squares[2 + q, m] = 0.0
    for j in range(ORDER):
        _squares(place[0], place[1], NODE[j], series[0], squares[0])
        for q in range(receivers):
            _squares(place[2], place[3], NODE[j], series[1 + q], squares[1])
            for m in range(_PARTS):
                squares[2 + q, m] += WEIGHT[j] * squares[0, m] * squares[1, m]
    for m in range(count):
        for q in range(receivers):
            out[line[m], q] += place[4, m] * squares[2 + q, m]


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _squares(offset, slope, node, series, out):
    """Write |Σ_n s_n P_n(x)|² at one node of several parts, x = offset + slope·node."""
    for m in range(_PARTS):
        x = offset[m] + slope[m] * node
        below = 1.0
        here = x
        real = series[0, m] + series[2, m] * x
        imag = series[1, m] + series[3, m] * x
        for n in range(1, ORDER - 1):
            above = UPWARD[n] * x * here - DOWNWARD[n] * below
            real += series[2 * n + 2, m] * above
            imag += series[2 * n + 3, m] * above
            below = here
            here = above
        out[m] = real * real + imag * imag


@numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _amplitudes(parts, line, out):
    """Write the series of A, real and imaginary parts, at β and then at −β, where q is the conjugate."""
    terms = parts.shape[3]
    rr = parts[0, 0, line]
    ri = parts[0, 1, line]
    ir = parts[1, 0, line]
    ii = parts[1, 1, line]
    for n in range(terms):
        out[0, n] = rr[n] - ii[n]
        out[1, n] = ri[n] + ir[n]
    for n in range(terms):
        out[0, terms + n] = rr[n] + ii[n]
        out[1, terms + n] = ir[n] - ri[n]


@numba.njit(forceinline=True, error_model="numpy")
def _excited_panel(edge, kappa, side, shift, tiny):
    """Return on which panel of |β| the part begins that starts at |κ|, if β < 0 there, and where it ends."""
    beta = side * kappa + shift
    if side > 0.0:
        n = count_below(edge, beta + tiny)
        return n - 1, False, (edge[n] - shift if n < edge.shape[0] else np.inf)
    if beta > tiny:  # towards β = 0
        n = count_below(edge, beta - tiny) - 1
        return n, False, shift - edge[n]
    n = count_below(edge, -beta + tiny)
    return n - 1, True, (edge[n] + shift if n < edge.shape[0] else np.inf)


@numba.njit(cache=True, error_model="numpy")
def _mark_needed(edge, transfer, share, needed):
    """Mark for every receiver the panels with more than a negligible share of ∫ |H̃|² dκ."""
    for q in range(transfer.shape[0]):
        total = 0.0
        for p in range(share.shape[0]):
            share[p] = 0.0
            for n in range(ORDER):  # Parseval: ∫ P_n² dx = 2/(2n + 1)
                squared = transfer[q, p, 2 * n] ** 2 + transfer[q, p, 2 * n + 1] ** 2
                share[p] += (edge[p + 1] - edge[p]) * squared / (2.0 * n + 1.0)
            total += share[p]
        for p in range(share.shape[0]):
            needed[q, p] = share[p] >= _NEGLIGIBLE * total


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
