"""Tables of transfer functions against direct evaluation, between their nodes and frequencies, and their
independence.
"""

import numpy as np
import pytest

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import CENTRE, RAIL, Receiver
from railvib.soil.fits import GroundFits
from railvib.soil.quadrature import strip_compliance_by_quadrature
from railvib.soil.rational_fit import RationalFit
from railvib.transfer import tabulate
from railvib.transfer.evaluation import Evaluation
from railvib.transfer.intensity import squares_at_level
from railvib.transfer.nodes import largest_wavenumber
from railvib.transfer.tabulate import distance_class, transfer_blocks
from railvib.transfer.track_response import track_response
from railvib.transfer.transfer_function import TransferFunction

SOFT = Ground(
    layers=[
        Layer(shear_speed=110.0, dilatational_speed=300.0, density=1700.0, loss_factor=0.08, thickness=3.0),
        Layer(shear_speed=220.0, dilatational_speed=500.0, density=1900.0, loss_factor=0.06),
    ]
)
RECEIVERS = (RAIL, *map(Receiver, (0.0, 5.0, 20.0, 1.0)))
"""The last one beside the centre line, under the track."""


@pytest.fixture(scope="module")
def functions(track, tables):
    return tables(SOFT, track, range(-3, 3), RECEIVERS)


def direct(track, receiver, frequency, beta):
    y = receiver.offset or 0.0
    c = strip_compliance_by_quadrature(SOFT, track.half_width, beta, [0.0, y], frequency, 1e-8)
    rail, force = track_response(track, beta, 2.0 * np.pi * frequency, c[0])
    return complex(rail if receiver.on_rail else force * c[1])


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


def test_many_receivers_are_handed_on_some_at_a_time(functions, track):
    """They share one object of what they have in common, and have the same values as alone."""
    receivers = [Receiver(offset) for offset in np.linspace(8.5, 15.5, 41).tolist()]
    batches = list(tabulate.transfer_blocks_by_class(SOFT, track, -3, receivers))
    assert list(map(len, batches)) == [tabulate.VALUES_AT_ONCE, 41 - tabulate.VALUES_AT_ONCE]
    tables = {receiver: table for batch in batches for receiver, table in batch.items()}
    for table in tables.values():
        assert table.shared is tables[receivers[0]].shared
    alone = transfer_blocks(SOFT, track, -3, [Receiver(15.5)])[Receiver(15.5)]
    np.testing.assert_array_equal(alone.transfer, tables[receivers[-1]].transfer)
    for name in ("frequency", "wavenumber", "compliance", "pole"):
        shared = getattr(tables[receivers[-1]].shared, name)
        np.testing.assert_array_equal(getattr(alone.shared, name), shared)


def test_a_receiver_does_not_depend_on_the_others(functions, track):
    alone = transfer_blocks(SOFT, track, 1, [Receiver(5.0)])[Receiver(5.0)]
    together = functions[Receiver(5.0)].blocks[1]
    np.testing.assert_array_equal(alone.transfer, together.transfer)
    np.testing.assert_array_equal(alone.shared.frequency, together.shared.frequency)
    for name in ("level", "square_level", "reference_slowness", "interpolation_error"):
        assert getattr(alone, name) == getattr(together, name)
    classes = [distance_class(receiver) for receiver in (RAIL, *map(Receiver, (0.0, 8.0, 8.1, 100.0)))]
    assert classes == [8.0, 8.0, 8.0, 16.0, 128.0]


def test_receivers_of_a_class_share_the_forces_on_the_ground(functions, track):
    """They are computed once, whichever receiver asks first, and are those of the track on the compliance."""
    near, far = (functions[Receiver(offset)].blocks[1] for offset in (5.0, 1.0))
    shared = near.shared
    assert far.shared is shared
    inverse = shared.inverse_force(track)
    assert far.shared.inverse_force(track) is inverse
    omega = 2.0 * np.pi * shared.frequency[:, None]
    _rail, force = track_response(track, shared.wavenumber, omega, shared.compliance)
    np.testing.assert_allclose(inverse * force, 1.0)
    np.testing.assert_array_equal(shared.inverse_force(None), 1.0)
    between = TransferFunction([near], track), TransferFunction([far], track)
    shared.squared_forces.clear()
    level, ks = near.level + 1, blocks.halfway(1, near.level, 3)
    values = [squares_at_level(function, 1, level, ks) for function in between]
    ((key, squared_force),) = shared.squared_forces.items()
    assert key[0] == track
    f = blocks.frequency(level, ks)
    beta, transfer = between[0].at(1, f)
    np.testing.assert_allclose(values[0], np.abs(transfer) ** 2, rtol=1e-9, atol=1e-12 * values[0].max())
    compliance = blocks.interpolated(1, near.level, f, shared.compliance)
    _rail, force = track_response(track, beta, 2.0 * np.pi * f[:, None], compliance)
    np.testing.assert_allclose(squared_force, np.abs(force) ** 2, rtol=1e-9)


def test_a_part_of_a_table_gives_the_same_as_the_whole(functions, track):
    table = functions[Receiver(20.0)].blocks[1]
    part = table.part(3, 6)
    nodes = slice(3 * ORDER, 7 * ORDER)
    assert part.nodes.panel_count == 4
    np.testing.assert_array_equal(part.shared.wavenumber, table.shared.wavenumber[:, nodes])
    np.testing.assert_allclose(part.reduced(track), table.reduced(track)[:, nodes], rtol=1e-12)


def test_certificates(functions):
    for receiver in RECEIVERS:
        for table in functions[receiver].blocks.values():
            assert table.interpolation_error < 1e-4
            assert table.shared.compliance_error < 1e-4
            assert not table.shared.quadrature


@pytest.mark.parametrize("receiver", RECEIVERS)
def test_the_error_that_a_table_states_is_that_of_what_is_read_from_it(receiver, functions, track):
    """Half-way between its frequencies, against direct values, with another code that interpolates."""
    for block in (-3, 0, 2):
        table = functions[receiver].blocks[block]
        places = blocks.halfway(block, table.level, 5)
        f = blocks.frequency(table.level + 1, places)
        beta, interpolated = functions[receiver].at(block, f)
        offset = receiver.offset or 0.0
        evaluate = Evaluation(GroundFits(SOFT, block, 1e-10), track, [offset], 1e-4)
        values = np.array(
            [evaluate(table.level + 1, int(k), row) for k, row in zip(places, beta, strict=True)]
        )
        direct = values[:, evaluate.row(receiver)]
        under = values[:, evaluate.row(RAIL if receiver.on_rail else CENTRE)]
        size = np.maximum(np.abs(direct), 1e-8 * np.abs(under).max(axis=1, keepdims=True))
        error = (np.abs(interpolated - direct) / size).max()
        assert error == pytest.approx(table.interpolation_error, rel=1e-3, abs=1e-11)


def test_quadrature_takes_over_where_the_fit_fails(track, monkeypatch):
    """A fit that misses its tolerance is not used: quadrature gives the same, and the record says so."""

    def failing(self, level, k):
        return RationalFit(np.array([1j]), np.array([1.0 + 0j]), 0j, 1.0, np.array([0.0]))

    ground = Ground(
        layers=[Layer(shear_speed=200.0, dilatational_speed=400.0, density=1800.0, loss_factor=0.2)]
    )
    fits = GroundFits(ground, -3, 1e-10)
    beta = np.linspace(0.0, 3.0, 9)
    evaluate = Evaluation(fits, track, [8.0], 1e-4)
    fitted = evaluate(0, int(blocks.indices(-3, 0)[0]), beta)
    assert not evaluate.failed
    monkeypatch.setattr(GroundFits, "at", failing)
    again = Evaluation(fits, track, [8.0], 1e-4)
    computed = again(0, int(blocks.indices(-3, 0)[0]), beta)
    np.testing.assert_allclose(computed, fitted, rtol=1e-6)
    assert len(again.failed) == 1


def test_static_below_the_tables(functions):
    function = TransferFunction(functions[RAIL].blocks.values())
    assert function.lowest == pytest.approx(10 ** (0.05 - 1.5))
    assert function.highest == pytest.approx(10**1.55)
