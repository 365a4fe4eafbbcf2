"""Classes of receivers by distance."""

import pytest

from railvib.parameters.receiver import Receiver
from railvib.transfer.receiver_classes import distance_class


@pytest.mark.parametrize(
    ("offset", "farthest"), [(None, 8.0), (0.0, 8.0), (8.0, 8.0), (8.1, 16.0), (100.0, 128.0)]
)
def test_a_class_reaches_to_a_power_of_two(offset, farthest):
    assert distance_class(Receiver(offset)) == farthest
