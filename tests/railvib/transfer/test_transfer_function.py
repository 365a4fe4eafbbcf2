"""Transfer functions against direct evaluation, between the nodes and frequencies of their tables."""

import numpy as np
import pytest

from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.receiver import RAIL, Receiver
from railvib.transfer.nodes import largest_wavenumber
from railvib.transfer.transfer_function import TransferFunction
from tests.railvib.transfer.soft_ground import RECEIVERS, SOFT, direct


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_against_direct_evaluation(receiver, functions, track):
    """At random places, none of them a node: 1e-4 where there is 1e-8 of the peak."""
    rng = np.random.default_rng([3, RECEIVERS.index(receiver)])
    for _ in range(25):
        f = float(np.exp(rng.uniform(np.log(0.1), np.log(35.0))))
        beta = float(2.0 * np.pi * f / 95.0 * rng.uniform(0.0, 1.4))
        expected = direct(track, receiver, f, beta)
        peak = np.abs(
            functions[receiver].along(np.full(60, f), 2.0 * np.pi * f / 95.0 * np.linspace(0.0, 1.3, 60))
        ).max()
        value = functions[receiver].along(np.array([f]), np.array([beta]))[0]
        assert abs(value - expected) < 1e-4 * max(abs(expected), 1e-4 * peak), (f, beta)


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_track_on_the_mean_against_direct_evaluation(receiver, track, tables):
    """The same where the track follows the mean; the ground at the centre line then does not move with it."""
    following = track.model_copy(update={"coupling": "mean"})
    function = tables(SOFT, following, range(2, 3), RECEIVERS)[receiver]
    rng = np.random.default_rng([5, RECEIVERS.index(receiver)])
    for _ in range(8):
        f = float(np.exp(rng.uniform(np.log(11.3), np.log(33.0))))
        slowness = rng.uniform(0.0, 1.4) / 95.0
        nodes = 2.0 * np.pi * f / 95.0 * np.linspace(0.0, 1.3, 60)
        peak = np.abs(function.along(np.full(60, f), nodes)).max()
        expected = direct(following, receiver, f, float(2.0 * np.pi * f * slowness))
        value = function.along(np.array([f]), np.array([2.0 * np.pi * f * slowness]))[0]
        assert abs(value - expected) < 1e-4 * max(abs(expected), 1e-4 * peak), (f, slowness)


def test_response_of_the_rail(functions, track):
    """The same by `response`, whose frequency may be negative, or zero, or below the tables."""
    rail = functions[RAIL]
    omega = np.array([60.0, -60.0, 0.0, 1e-3, -1e-3])
    value = rail.response(np.array([0.5, -0.5, 0.5, 0.5, 0.5]), omega)
    assert abs(value[0] / direct(track, RAIL, 60.0 / (2.0 * np.pi), 0.5) - 1.0) < 1e-4
    assert value[1] == pytest.approx(np.conj(value[0]))
    assert abs(value[2] / direct(track, RAIL, 0.02, 0.5) - 1.0) < 1e-4
    assert value[3] == value[2]
    assert value[4] == np.conj(value[3])
    with pytest.raises(ValueError, match="above the tabulated"):
        rail.response(np.array([0.1]), np.array([2.0 * np.pi * 50.0]))


def test_beyond_the_table(functions, track):
    ground = functions[Receiver(5.0)]
    beta = np.geomspace(45.0, 1e4, 20000)
    for frequency in (0.5, 10.0, 30.0):
        np.testing.assert_array_equal(ground.along(np.full(20000, frequency), beta), 0.0)
    assert largest_wavenumber(track) == pytest.approx((2000.0 * 1e9 / 12.8e6) ** 0.25)


def test_blocks_join(functions):
    """Two neighbouring blocks give the same at their common edge."""
    for receiver in RECEIVERS:
        for block in (0, 1):
            edge = np.array([blocks.edges(block)[1]])
            beta = 2.0 * np.pi * edge[0] / 95.0 * np.linspace(0.05, 1.2, 24)
            sides = [
                functions[receiver].along(edge.repeat(24) * (1.0 + shift), beta) for shift in (-1e-10, 1e-10)
            ]
            assert np.abs(sides[0] - sides[1]).max() < 1e-4 * np.abs(sides[0]).max()


def test_static_below_the_tables(functions):
    function = TransferFunction(functions[RAIL].blocks.values())
    assert function.lowest == pytest.approx(10 ** (0.05 - 1.5))
    assert function.highest == pytest.approx(10**1.55)
