"""Panels that follow the waves' slownesses."""

import numpy as np
import pytest

from railvib.transfer.nodes import TOP, Nodes, largest_wavenumber, node_range
from tests.railvib.transfer.soft_ground import SOFT

EDGE = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
NODES = Nodes(0.01, 20.0, EDGE)
FREQUENCY = np.array([1.0, 30.0])


def test_edges_follow_a_slowness_and_go_geometrically_beyond():
    edge = NODES.panel_edges(FREQUENCY)
    dense = 2.0 * np.pi * FREQUENCY * 0.01
    np.testing.assert_allclose(edge[:, :3], dense[:, None] * [0.0, 0.5, 1.0])
    np.testing.assert_allclose(edge[:, 3], np.sqrt(dense * 20.0))
    np.testing.assert_allclose(edge[:, 4], 20.0)


def test_nodes_lie_inside_their_panels():
    edge = NODES.panel_edges(FREQUENCY)
    beta = NODES.wavenumber(FREQUENCY).reshape(2, 4, -1)
    assert np.all(beta > edge[:, :-1, None])
    assert np.all(beta < edge[:, 1:, None])


@pytest.mark.parametrize("u", [0.01, 0.3, 0.7, 1.2, 1.9])
def test_panels_that_hold_pairs_of_frequency_and_wavenumber(u):
    beta = Nodes(0.01, 20.0, np.array([0.0, u])).panel_edges(FREQUENCY)[:, 1]
    first, last = NODES.panels(FREQUENCY, beta)
    edge = NODES.part(first, last).panel_edges(FREQUENCY)
    assert np.all((edge[:, 0] <= beta) & (beta <= edge[:, -1]))
    assert last - first <= 2


def test_nodes_with_the_same_values_are_equal():
    same = Nodes(0.01, 20.0, EDGE.copy())
    assert same == NODES
    assert hash(same) == hash(NODES)
    for other in (Nodes(0.011, 20.0, EDGE), Nodes(0.01, 21.0, EDGE), Nodes(0.01, 20.0, EDGE[:-1])):
        assert other != NODES


def test_the_range_of_tables(track):
    """As far as the rail on its pads needs it, or twice as far as the slowest wave at high frequency."""
    top, largest = node_range(SOFT, track, 1.0)
    assert top == pytest.approx(TOP / SOFT.slowest_speed)
    assert largest == largest_wavenumber(track)
    assert node_range(SOFT, track, 1.0, refinement=2)[1] == 2.0 * largest
    assert node_range(SOFT, track, 400.0)[1] == pytest.approx(2.0 * 2.0 * np.pi * 400.0 * top)
