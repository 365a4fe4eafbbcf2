"""Compact arrays of the page: levels as whole hundredths of a decibel, in base 64."""

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from queries.database import fill_gaps

NONE = -32768
"""Stands for a missing level."""


def hundredths(level: Any) -> NDArray[np.int16]:
    """Return levels in dB as whole hundredths."""
    value = np.round(100.0 * np.asarray(fill_gaps(level), dtype=float))
    return np.where(np.isfinite(value), np.clip(value, NONE + 1, -NONE - 1), NONE).astype("<i2")


def text(array: NDArray[Any]) -> str:
    """Return the bytes of an array as text."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
