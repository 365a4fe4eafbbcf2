"""Whether two runs hold the same results."""

from pathlib import Path

import numpy as np

from railvib.errors import InputError
from sweep.storage import records, store


def largest_difference(one: Path, other: Path) -> tuple[float, int]:
    """Return the largest difference of any array of two runs over that array's largest value, and how many.

    Raises
    ------
    InputError
        If they do not hold the same units and arrays.
    """
    found = [{each["unit_id"]: each for each in records.committed(at)} for at in (one, other)]
    if found[0].keys() != found[1].keys():
        raise InputError(f"{one} and {other}: do not hold the same units")
    worst, compared = 0.0, 0
    for unit, record in found[0].items():
        here, _ = store.read_recorded(one, record)
        there, _ = store.read_recorded(other, found[1][unit])
        if here.keys() != there.keys():
            raise InputError(f"{one} and {other}: the arrays of {unit} differ")
        for name, array in here.items():
            if not np.issubdtype(array.dtype, np.inexact):
                continue
            size = float(np.nanmax(np.abs(array), initial=0.0))
            if array.shape != there[name].shape or (np.isnan(array) != np.isnan(there[name])).any():
                worst = np.inf
            elif size > 0.0:
                worst = max(worst, float(np.nanmax(np.abs(array - there[name]))) / size)
            compared += 1
    return worst, compared
