"""Whether two runs hold the same results."""

from pathlib import Path

import numpy as np

from railvib.errors import InputError
from sweep.storage import records, store


def largest_difference(first: Path, second: Path) -> tuple[float, int]:
    """Return the largest difference of any array of two runs over its largest value, and their number.

    Raises
    ------
    InputError
        If they do not hold the same units and arrays.
    """
    ours, theirs = ({record["unit_id"]: record for record in records.commits(run)} for run in (first, second))
    if ours.keys() != theirs.keys():
        raise InputError(f"{first} and {second}: do not hold the same units")
    largest, compared = 0.0, 0
    for unit, record in ours.items():
        arrays, _ = store.read_result(first, record)
        others, _ = store.read_result(second, theirs[unit])
        if arrays.keys() != others.keys():
            raise InputError(f"{first} and {second}: the arrays of {unit} differ")
        for name, array in arrays.items():
            if np.issubdtype(array.dtype, np.inexact):
                largest = max(largest, _difference(array, others[name]))
                compared += 1
    return largest, compared


def _difference(array: np.ndarray, other: np.ndarray) -> float:
    """Return the largest difference over the largest value; infinite if shapes or places of NaN differ."""
    if array.shape != other.shape or (np.isnan(array) != np.isnan(other)).any():
        return np.inf
    size = float(np.nanmax(np.abs(array), initial=0.0))
    difference = float(np.nanmax(np.abs(array - other), initial=0.0))
    if difference == 0.0:
        return 0.0
    return difference / size if size > 0.0 else np.inf
