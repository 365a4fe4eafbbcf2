"""Squares of transfer functions, interpolated between their frequencies."""

import numpy as np
import pytest

from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.receiver import RAIL, Receiver
from railvib.transfer.intensity import group_by_nodes, interpolate_squares, squares
from tests.railvib.transfer.soft_ground import RECEIVERS


@pytest.mark.parametrize("receiver", RECEIVERS, ids=lambda receiver: receiver.label)
@pytest.mark.parametrize("block", [-2, 2])
def test_squares_between_their_frequencies(receiver, block, functions):
    """They are those of the interpolated function, to twice its tolerance, where that is not negligible."""
    low, high = blocks.edges(block)
    f = np.geomspace(1.001 * low, 0.999 * high, 23)
    _beta, transfer = functions[receiver].at(block, f)
    (square,) = interpolate_squares([functions[receiver]], block, f)
    size = np.maximum(np.abs(transfer) ** 2, 1e-8 * (np.abs(transfer) ** 2).max(axis=1, keepdims=True))
    assert (np.abs(square - np.abs(transfer) ** 2) / size).max() < 2e-4


def test_squares_are_kept_with_their_table(functions):
    function = functions[Receiver(5.0)]
    assert squares(function, 1) is squares(function, 1)
    value = squares(function, 1).value
    assert value.shape[0] == blocks.indices(1, function.blocks[1].square_level).size


def test_panels_hold_all_but_a_negligible_share(functions):
    for receiver in (RAIL, Receiver(20.0)):
        table = squares(functions[receiver], 2)
        assert table.panels.max() <= functions[receiver].blocks[2].nodes.panel_count
    assert table.panels.max() < functions[receiver].blocks[2].nodes.panel_count  # decayed beyond the waves


def test_receivers_are_grouped_by_their_nodes(functions):
    f = np.array([0.5, 3.0, 20.0])
    groups = [(set(members), block, lines.tolist()) for members, block, lines in group_by_nodes(functions, f)]
    near = {receiver for receiver in RECEIVERS if receiver != Receiver(20.0)}
    for block, line in zip(blocks.nearest_block(f, range(-3, 3)).tolist(), range(3), strict=True):
        assert (near, block, [line]) in groups
        assert ({Receiver(20.0)}, block, [line]) in groups
    assert len(groups) == 6
