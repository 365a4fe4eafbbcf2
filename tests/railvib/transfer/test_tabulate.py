"""Tables depend on their own inputs only, and state the error of what is read from them."""

import numpy as np
import pytest

from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.receiver import CENTRE, RAIL, Receiver
from railvib.soil.fits import GroundFits
from railvib.transfer import tabulate
from railvib.transfer.evaluation import Evaluation
from railvib.transfer.receiver_classes import VALUES_AT_ONCE
from railvib.transfer.tabulate import transfer_blocks
from tests.railvib.transfer.soft_ground import RECEIVERS, SOFT


def test_many_receivers_are_handed_on_some_at_a_time(functions, track):
    """They share one object of what they have in common, and have the same values as alone."""
    receivers = [Receiver(offset) for offset in np.linspace(8.5, 15.5, 41).tolist()]
    batches = list(tabulate.transfer_blocks_by_class(SOFT, track, -3, receivers))
    assert list(map(len, batches)) == [VALUES_AT_ONCE, 41 - VALUES_AT_ONCE]
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
        places = blocks.halfway_indices(block, table.level, 5)
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
