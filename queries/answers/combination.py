"""What several soils may share: a track, train, unevenness and speed, and rows about them as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Combination:
    """A track, train, unevenness and speed, which several soils may share."""

    track: str
    train: str
    unevenness: str
    speed_kmh: float


def columns(
    connection: duckdb.DuckDBPyConnection, query: str, given: Sequence[Any] = ()
) -> dict[str, NDArray[Any]]:
    """Return the columns of a query as arrays; NULL becomes NaN."""
    found = connection.execute(query, list(given)).fetchnumpy()
    return {
        name: array.filled(np.nan)
        if isinstance(array, np.ma.MaskedArray) and array.dtype.kind == "f"
        else np.asarray(array)
        for name, array in found.items()
    }
