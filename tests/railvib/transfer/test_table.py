"""What the tables of a class of receivers share."""

import numpy as np

from railvib.numerics import frequency_blocks as blocks
from railvib.numerics.frequency_interpolation import interpolate
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.receiver import Receiver
from railvib.transfer.intensity import squares_at_level
from railvib.transfer.track_response import track_response
from railvib.transfer.transfer_function import TransferFunction


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
    level, ks = near.level + 1, blocks.halfway_indices(1, near.level, 3)
    values = [squares_at_level(function, 1, level, ks) for function in between]
    ((key, squared_force),) = shared.squared_forces.items()
    assert key[0] == track
    f = blocks.frequency(level, ks)
    beta, transfer = between[0].at(1, f)
    np.testing.assert_allclose(values[0], np.abs(transfer) ** 2, rtol=1e-9, atol=1e-12 * values[0].max())
    compliance = interpolate(1, near.level, f, shared.compliance)
    _rail, force = track_response(track, beta, 2.0 * np.pi * f[:, None], compliance)
    np.testing.assert_allclose(squared_force, np.abs(force) ** 2, rtol=1e-9)


def test_a_part_of_a_table_gives_the_same_as_the_whole(functions, track):
    table = functions[Receiver(20.0)].blocks[1]
    part = table.part(3, 6)
    nodes = slice(3 * ORDER, 7 * ORDER)
    assert part.nodes.panel_count == 4
    np.testing.assert_array_equal(part.shared.wavenumber, table.shared.wavenumber[:, nodes])
    np.testing.assert_allclose(part.reduced(track), table.reduced(track)[:, nodes], rtol=1e-12)
