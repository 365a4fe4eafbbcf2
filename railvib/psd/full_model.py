"""The full model: the train moves, and a fixed receiver hears many excitation frequencies at once.

A load P e^{iωt} at α_l + vt has at a fixed point the spectrum S_0 = (1/v) H̃(κ, y, 2πf) e^{iκx} Σ_l P_l(ω)
e^{−iκα_l} with κ = (ω − 2πf)/v: no inverse transform, only H̃ at the
receiving frequency, over wavenumber. With β = ω/v = κ + 2πf/v and

    q_l(β) = P_l(βv) e^{−iβα_l} √S_w(|β|),        A(β, f) = Σ_l q_l(β) e^{2πifα_l/v}

the response is S(f) = (1/(T v²)) ∫ |H̃(κ, f)|² |A(κ + 2πf/v, f)|² dκ over all κ (Eq. 29). The q_l are smooth,
because the phases of the forces are taken out, and are computed once for every receiving frequency, by
`railvib.psd.excitation`.

The integral over a panel of κ on which |H̃|² is a polynomial is a weighted sum of its values at the panel's
nodes. The weights follow from the excitation alone: receivers whose tables share their nodes share them.
"""

from collections.abc import Collection, Mapping

import numpy as np

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import threads
from railvib.numerics.vector_math import turned
from railvib.numerics.wavenumber_panels import FROM_POWERS, ORDER
from railvib.parameters.receiver import Receiver
from railvib.psd._kernels.averages import panel_sums
from railvib.psd._kernels.moments import moments
from railvib.psd.excitation import Excitation
from railvib.transfer.intensity import same_nodes, squares
from railvib.transfer.nodes import Nodes
from railvib.transfer.tabulate import distance_class
from railvib.transfer.transfer_function import TransferFunction

_LINES_AT_ONCE = 64
RECEIVERS_AT_ONCE = 8
"""Whose tables are held at the same time."""


@threads.limited
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
        The receivers' tabulated transfer functions, taken some at a time.
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
        weights = _Weights(excited, speed, frequency)
        ordered = sorted(receivers, key=_turn)
        for i in range(0, len(ordered), RECEIVERS_AT_ONCE):
            functions = {each: receivers[each] for each in ordered[i : i + RECEIVERS_AT_ONCE]}
            groups = [
                (members, block, own, [squares(functions[each], block) for each in members])
                for members, block, own in same_nodes(functions, frequency)
            ]
            nodes = [functions[members[0]].blocks[block].nodes for members, block, *_ in groups]
            weights.keep(nodes)
            for start in range(0, frequency.size, _LINES_AT_ONCE):
                for (members, block, own, tables), shared in zip(groups, nodes, strict=True):
                    lines = own[slice(*np.searchsorted(own, [start, start + _LINES_AT_ONCE]))]
                    if not lines.size:
                        continue
                    stencils = {
                        level: blocks.stencils(block, level, frequency[lines])
                        for level in {each.level for each in tables}
                    }
                    panels = [each.panels[stencils[each.level][0]] for each in tables]
                    weight = weights.at(shared, lines, np.max(panels, axis=0)).reshape(lines.size, -1)
                    for receiver, each, needed in zip(members, tables, panels, strict=True):
                        psd[receiver][lines] = panel_sums(*stencils[each.level], each.value, needed, weight)
                    spent.evaluations += 2 * len(members) * weight.size
                    spent.kernel_calls += len(members)
    return {receiver: each / (train_length * speed) for receiver, each in psd.items()}


class _Weights:
    """The weights of tables' nodes at receiving frequencies, held for the receivers that share them.

    Parameters
    ----------
    excited, speed, frequency
        As for `passage_spectra`.
    """

    def __init__(self, excited: Excitation, speed: float, frequency: np.ndarray) -> None:
        self._excited = excited
        self._speed = speed
        self._frequency = frequency
        self._made: dict[tuple[Nodes, bytes], tuple[np.ndarray, np.ndarray]] = {}
        """At which panels, and what they are."""
        self._parts = 0, np.empty(0)

    def keep(self, nodes: Collection[Nodes]) -> None:
        """Let go of all weights but those of some nodes."""
        self._made = {key: made for key, made in self._made.items() if key[0] in nodes}

    def at(self, nodes: Nodes, lines: np.ndarray, panels: np.ndarray) -> np.ndarray:
        """Return the weights of the nodes of the first panels, (lines, panels, order).

        Parameters
        ----------
        nodes
            The nodes.
        lines
            Which frequencies, ascending, of the same `_LINES_AT_ONCE`.
        panels
            How many are wanted, (lines,).
        """
        key = nodes, lines.tobytes()
        if key not in self._made:
            shape = lines.size, nodes.panel_count
            self._made[key] = np.zeros(shape, bool), np.zeros((*shape, ORDER))
        known, weight = self._made[key]
        missing = (np.arange(known.shape[1]) < panels[:, None]) & ~known
        if missing.any():
            moment = np.zeros(weight.shape)
            start = int(lines[0]) // _LINES_AT_ONCE * _LINES_AT_ONCE
            shift = 2.0 * np.pi * self._frequency[lines] / self._speed
            edge = nodes.panel_edges(self._frequency[lines])
            of, limits = self._excited.edge, self._excited.wavenumbers
            moments(edge, missing, shift, self._turned(start), lines - start, of, *limits, moment)
            # All together: the last digits of a product may depend on how many rows it has.
            made = (moment.reshape(-1, ORDER) @ FROM_POWERS).reshape(moment.shape)
            if known.any():
                weight[missing] = made[missing]
            else:
                weight[:] = made
            known |= missing
        return weight

    def _turned(self, start: int) -> np.ndarray:
        """Return the parts of A for the lines from one on, which receivers with other nodes share."""
        if not self._parts[1].size or self._parts[0] != start:
            f = self._frequency[start : start + _LINES_AT_ONCE]
            turn = turned(2.0 * np.pi / self._speed * f[:, None] * self._excited.axle_position)
            self._parts = start, self._excited.amplitude_parts(turn)
        return self._parts[1]


def _turn(receiver: Receiver) -> tuple[float, float]:
    """Return what receivers are sorted by: class by class, as those of one share their nodes.

    The farthest class first, whose tables others, who begin at the track, have read last and may have left at
    hand; in a class the nearest first, which needs the most panels.
    """
    return -distance_class(receiver), receiver.rank
