"""Tables of receptances: against single values, their interpolation, and what they hold for the figures."""

import numpy as np
import pytest

from railvib.forces.moving_transfer import moving_transfer
from railvib.forces.receptance import receptances, tabulate_receptances
from railvib.forces.smooth_receptance import Load
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.wavenumber_panels import WEIGHT, nodes_between
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL
from railvib.transfer.highest_frequencies import highest_tabulated_frequency
from railvib.transfer.track_response import track_response

SOFT = Ground(layers=[Layer(shear_speed=150.0, dilatational_speed=400.0, density=1800.0, loss_factor=0.1)])
DISTANCES = [-19.0, -2.7, 0.0, 2.7, 19.0]


@pytest.fixture(scope="module")
def rail(track, tables):
    return tables(SOFT, track, range(-3, 5), (RAIL,))[RAIL]


@pytest.mark.parametrize("speed", [0.0, 40.0])
def test_interpolation(rail, track, speed):
    table = tabulate_receptances(rail, track, speed, DISTANCES, range(-3, 3))
    f = np.array([0.2, 0.9, 3.3, 7.1, 16.0, 34.0])
    single = receptances(rail, track, speed, DISTANCES, f)
    np.testing.assert_allclose(np.abs(table.at(f) - single) / np.abs(single[:, 2:3]), 0.0, atol=3e-5)
    low = table.at(np.array([1e-3, 0.0]))
    np.testing.assert_allclose(
        low, np.broadcast_to(table.at(np.array([blocks.edges(-3)[0]])), low.shape), rtol=1e-12
    )


def test_a_table_tells_its_blocks_from_their_halos(rail, track):
    table = tabulate_receptances(rail, track, 0.0, DISTANCES, range(0, 2))
    f = table.frequency[table.inside]
    assert np.all(np.diff(f) > 0.0)
    assert f[0] == pytest.approx(blocks.edges(0)[0])
    assert f[-1] < blocks.edges(1)[1]
    assert table.frequency.size - f.size >= 2 * 2 * blocks.HALO


@pytest.mark.parametrize(
    ("speed", "frequency"), [(0.0, 20.0), (3.0, 1.0), (40.0, 0.5), (40.0, 20.0), (40.0, 34.0)]
)
def test_against_quadrature(rail, track, speed, frequency):
    """The same integral by composite quadrature of the tabulated response, fine enough for any panel."""
    omega = 2.0 * np.pi * frequency
    bends = [0.0, omega / speed if speed else rail.reach]
    step = 0.001 * 1.1 ** np.arange(200)
    edge = np.add.outer(bends, np.concatenate([-step, [0.0], step])).ravel()
    edge = np.unique(np.concatenate([edge, np.linspace(-rail.reach, rail.reach, 4001)]))
    edge = edge[np.abs(edge) <= rail.reach]
    beta = nodes_between(edge)
    weight = (0.5 * np.diff(edge)[:, None] * WEIGHT).ravel()
    value = weight * rail.response(beta, omega - beta * speed)
    direct = np.exp(1j * np.multiply.outer(DISTANCES, beta)) @ value
    edge = np.linspace(rail.reach, 20.0 * rail.reach, 2001)
    far, far_weight = nodes_between(edge), (0.5 * np.diff(edge)[:, None] * WEIGHT).ravel()
    for side in (-1.0, 1.0):
        tail, _force = track_response(track, far, omega - side * far * speed, 0.0)
        direct += np.exp(1j * side * np.multiply.outer(DISTANCES, far)) @ (far_weight * tail)
    direct /= 2.0 * np.pi
    value = receptances(rail, track, speed, DISTANCES, [frequency])[0]
    np.testing.assert_allclose(np.abs(value - direct) / np.abs(direct[2]), 0.0, atol=1e-6)


@pytest.mark.parametrize("speed", [0.0, 6.0, 40.0, 90.0])
def test_distant_axles(rail, track, speed):
    """Where waves turn fast and where the damping's change of sign outlasts them."""
    distances = [-101.5, -40.0, 0.0, 40.0, 101.5]
    table = tabulate_receptances(rail, track, speed, distances, range(-3, 3))
    f = np.geomspace(0.04, 35.0, 150)
    direct = receptances(rail, track, speed, distances, f, 1e-6)
    np.testing.assert_allclose(np.abs(table.at(f) - direct) / np.abs(direct[:, 2:3]), 0.0, atol=1e-5)
    assert np.all(table.interpolation_error <= 1e-5)


def test_the_change_of_sign_outlasts_the_waves(rail, track):
    load = Load(rail, track, 25.0, np.array([-2000.0, -1500.0, 1500.0, 2000.0]))
    f = np.array([8.0, 20.0])
    value = receptances(rail, track, load.speed, load.distance, f, 1e-8)
    np.testing.assert_allclose(load.sign_change(f) / value, 1.0, atol=0.05)


def test_blocks_together_are_those_alone(rail, track):
    together = tabulate_receptances(rail, track, 40.0, DISTANCES, [-1, 0, 1])
    alone = [tabulate_receptances(rail, track, 40.0, DISTANCES, [block]) for block in (-1, 0, 1)]
    np.testing.assert_array_equal(together.level, np.concatenate([table.level for table in alone]))
    np.testing.assert_array_equal(together.receptance, np.concatenate([table.receptance for table in alone]))


def test_columns_are_signed_distances(rail, track):
    block = tabulate_receptances(rail, track, 40.0, [2.7, -2.7, 0.0, 2.7], [0])
    np.testing.assert_array_equal(block.distance, [-2.7, 0.0, 2.7])
    ahead, behind = block.receptance[:, 2], block.receptance[:, 0]
    assert np.abs(ahead / behind - 1.0).max() > 1e-2  # a moving load breaks the symmetry


def test_transfer_function_of_a_moving_load(rail):
    moving = moving_transfer(rail, 40.0, [0, 1])
    assert moving.rail_moving.shape == moving.wavenumber.shape
    assert np.all(np.diff(moving.frequency) > 0.0)
    np.testing.assert_allclose(moving.frequency[[0, 25]], [blocks.edges(0)[0], blocks.edges(1)[0]])
    assert moving.frequency[-1] < blocks.edges(1)[1]
    table = rail.blocks[1].nodes.wavenumber(moving.frequency)
    assert moving.wavenumber.shape[1] < 1.5 * table.shape[1]
    for row in (7, 45):
        present = np.isfinite(moving.wavenumber[row])
        assert np.all(np.diff(moving.wavenumber[row][present]) > 0.0)
        known = np.isfinite(moving.rail_moving[row])
        assert known.any()
        beta = moving.wavenumber[row][known]
        seen = 2.0 * np.pi * moving.frequency[row] - beta * 40.0
        np.testing.assert_allclose(moving.rail_moving[row][known], rail.response(beta, seen))


def test_reach(rail, track):
    top = highest_tabulated_frequency(track, 30.0, 40.0)
    assert 30.0 + 100.0 < top < 30.0 + 150.0
    with pytest.raises(ValueError, match="above the tabulated"):
        receptances(rail, track, 40.0, [0.0], [400.0])
