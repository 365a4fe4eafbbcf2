"""Classes of receivers by distance, and how many receivers are computed together."""

import numpy as np

from railvib.parameters.receiver import Receiver

VALUES_AT_ONCE = 32
"""Receivers whose values are computed together; their tables of one level are yielded together."""
RECEIVERS_AT_ONCE = 8
"""Receivers whose tables are in memory at once."""


def distance_class(receiver: Receiver) -> float:
    """Return the farthest distance of the receiver's class, m: 8, 16, 32, …; 8 for the rail."""
    return float(8.0 * 2.0 ** max(np.ceil(np.log2(max(receiver.offset or 0.0, 1.0) / 8.0)), 0.0))
