"""The full model: the train moves, and a fixed receiver hears many excitation frequencies at once.

A load P e^{iωt} at α_l + vt has at a fixed point the spectrum

    S_0 = (1/v) H̃(κ, y, 2πf) e^{iκx} Σ_l P_l(ω) e^{−iκα_l},        κ = (ω − 2πf)/v

which takes no inverse transform, only H̃ at the receiving frequency, over wavenumber. With β = ω/v = κ +
2πf/v and

    q_l(β) = P_l(βv) e^{−iβα_l} √S_w(|β|),        A(β, f) = Σ_l q_l(β) e^{2πifα_l/v}

the response is S(f) = (1/(T v²)) ∫ |H̃(κ, f)|² |A(κ + 2πf/v, f)|² dκ over all κ (Eq. 29). The q_l are smooth,
because the phases of the forces are taken out. `railvib.psd.excitation` computes them once for every
receiving frequency.

The integral over a panel of κ on which |H̃|² is a polynomial is a weighted sum of its values at the panel's
nodes. The weights follow from the excitation alone: receivers whose tables share their nodes share the
weights.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import frequency_interpolation, threads
from railvib.numerics.vector_math import phasors
from railvib.numerics.wavenumber_panels import FROM_POWERS, ORDER
from railvib.parameters.receiver import Receiver
from railvib.psd._kernels.averages import panel_sums
from railvib.psd._kernels.moments import moments
from railvib.psd.excitation import Excitation
from railvib.transfer.intensity import Squares, group_by_nodes, squares
from railvib.transfer.nodes import Nodes
from railvib.transfer.receiver_classes import RECEIVERS_AT_ONCE, distance_class
from railvib.transfer.transfer_function import TransferFunction

_LINES_AT_ONCE = 64
"""Lines whose weights are computed together."""


@threads.single()
def passage_spectra(
    receivers: Mapping[Receiver, TransferFunction],
    excited: Excitation | Sequence[Excitation],
    train_length: float,
    speed: float,
    frequency: np.ndarray,
) -> dict[Receiver, np.ndarray]:
    """Return PSDs of displacement at fixed points, averaged over the passage (Eq. 29 over T).

    Parameters
    ----------
    receivers
        The receivers' tabulated transfer functions, taken some at a time.
    excited
        The forces, from `excitation`, or several sets that are independent of each other.
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
        for function in receivers.values():
            blocks.check_coverage(frequency, function.blocks)
        independent = (excited,) if isinstance(excited, Excitation) else tuple(excited)
        weights = _Weights(independent, speed, frequency)
        ordered = sorted(receivers, key=_order)
        for first_receiver in range(0, len(ordered), RECEIVERS_AT_ONCE):
            groups = _groups(
                {
                    receiver: receivers[receiver]
                    for receiver in ordered[first_receiver : first_receiver + RECEIVERS_AT_ONCE]
                },
                frequency,
            )
            weights.discard_all_but({group.nodes for group in groups})
            for first_line in range(0, frequency.size, _LINES_AT_ONCE):
                for group in groups:
                    ends = np.searchsorted(group.lines, [first_line, first_line + _LINES_AT_ONCE])
                    lines = group.lines[slice(*ends)]
                    if not lines.size:
                        continue
                    integrals, evaluations = _integrate(group, lines, frequency[lines], weights)
                    for receiver, integral in zip(group.receivers, integrals, strict=True):
                        psd[receiver][lines] = integral
                    spent.evaluations += evaluations
                    spent.kernel_calls += len(group.receivers)
    return {receiver: integral / (train_length * speed) for receiver, integral in psd.items()}


class _Group(NamedTuple):
    """Receivers whose tables have the same nodes in a block."""

    receivers: list[Receiver]
    block: int
    nodes: Nodes
    lines: np.ndarray
    """Which of the receiving frequencies lie in the block, ascending."""
    squares: list[Squares]
    """|H̃|² of each receiver."""


def _groups(functions: Mapping[Receiver, TransferFunction], frequency: np.ndarray) -> list[_Group]:
    return [
        _Group(
            members,
            block,
            functions[members[0]].blocks[block].nodes,
            lines,
            [squares(functions[receiver], block) for receiver in members],
        )
        for members, block, lines in group_by_nodes(functions, frequency)
    ]


def _integrate(
    group: _Group, lines: np.ndarray, frequency: np.ndarray, weights: "_Weights"
) -> tuple[list[np.ndarray], int]:
    """Return ∫ |H̃|² |A|² dκ of each receiver at some lines, (lines,), and how many values that took."""
    stencils = {
        level: frequency_interpolation.stencils(group.block, level, frequency)
        for level in {squares.level for squares in group.squares}
    }
    panels = [squares.panels[stencils[squares.level][0]] for squares in group.squares]
    weight = weights.at(group.nodes, lines, np.max(panels, axis=0)).reshape(lines.size, -1)
    integrals = [
        panel_sums(*stencils[squares.level], squares.value, count, weight)
        for squares, count in zip(group.squares, panels, strict=True)
    ]
    return integrals, 2 * len(integrals) * weight.size


class _Weights:
    """The weights of tables' nodes at receiving frequencies, kept for the receivers that share them.

    Parameters
    ----------
    excited
        Sets of forces that are independent of each other.
    speed, frequency
        As for `passage_spectra`.
    """

    def __init__(self, excited: Sequence[Excitation], speed: float, frequency: np.ndarray) -> None:
        self._excited = excited
        self._speed = speed
        self._frequency = frequency
        self._weights: dict[tuple[Nodes, bytes], tuple[np.ndarray, np.ndarray]] = {}
        """By nodes and lines: at which panels weights are known, and the weights."""
        self._amplitude: tuple[tuple[int, int], np.ndarray] | None = None
        """First line, number of the set, and parts of A, for the last ones asked for."""

    def discard_all_but(self, nodes: Collection[Nodes]) -> None:
        """Discard all weights but those of some nodes."""
        self._weights = {key: weights for key, weights in self._weights.items() if key[0] in nodes}

    def at(self, nodes: Nodes, lines: np.ndarray, panels: np.ndarray) -> np.ndarray:
        """Return the weights of the nodes of the first panels, (lines, panels, order).

        Parameters
        ----------
        nodes
            The nodes.
        lines
            Which frequencies, ascending, all among the same `_LINES_AT_ONCE`.
        panels
            Number of panels wanted, (lines,).
        """
        key = nodes, lines.tobytes()
        if key not in self._weights:
            shape = lines.size, nodes.panel_count
            self._weights[key] = np.zeros(shape, bool), np.zeros((*shape, ORDER))
        known, weight = self._weights[key]
        missing = (np.arange(known.shape[1]) < panels[:, None]) & ~known
        if missing.any():
            moment = np.zeros(weight.shape)
            first = int(lines[0]) // _LINES_AT_ONCE * _LINES_AT_ONCE
            for number, excited in enumerate(self._excited):
                part = np.zeros(weight.shape)
                moments(
                    nodes.panel_edges(self._frequency[lines]),
                    missing,
                    2.0 * np.pi * self._frequency[lines] / self._speed,
                    self._amplitude_parts(first, number),
                    lines - first,
                    excited.edge,
                    *excited.wavenumbers,
                    part,
                )
                moment += part
            # All together: the last digits of a product may depend on its number of rows.
            computed = (moment.reshape(-1, ORDER) @ FROM_POWERS).reshape(moment.shape)
            if known.any():
                weight[missing] = computed[missing]
            else:
                weight[:] = computed
            known |= missing
        return weight

    def _amplitude_parts(self, first: int, number: int) -> np.ndarray:
        """Return the parts of A of a set of forces for the lines from one on, which several nodes need."""
        if self._amplitude is None or self._amplitude[0] != (first, number):
            excited = self._excited[number]
            f = self._frequency[first : first + _LINES_AT_ONCE]
            phase = phasors(2.0 * np.pi / self._speed * f[:, None] * excited.axle_position)
            self._amplitude = (first, number), excited.amplitude_parts(phase)
        return self._amplitude[1]


def _order(receiver: Receiver) -> tuple[float, float]:
    """Return a key that sorts receivers class by class, as those of a class share their nodes.

    The farthest class comes first: whoever computed before began at the track, and may have its tables still
    in memory. In a class the nearest receiver comes first, which needs the most panels.
    """
    return -distance_class(receiver), receiver.rank
