"""Checks of stored arrays against their records, and memory of the arrays already checked.

An array in memory is not read again: tables share many arrays. An array that is read again is not hashed
again: the checksums that its chunks had when it was written or last hashed reveal any later change, with
a chance of one in four billion to miss it.
"""

import hashlib
from collections.abc import Mapping
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from sweep.storage.cache import Latest

REMEMBERED = 4096
"""Number of arrays whose chunk checksums are kept, a few hundred bytes each."""

_in_memory: "WeakValueDictionary[str, NDArray[Any]]" = WeakValueDictionary()
_chunks: Latest[str, bytes] = Latest(REMEMBERED)


def checksum(array: NDArray[Any]) -> dict[str, Any]:
    """Return sha256 of the raw bytes (C order, little endian), shape and dtype of an array."""
    array = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).reshape(array.shape)
    raw = array.reshape(-1).view(np.uint8) if array.size else array.reshape(-1)
    return {
        "sha256": hashlib.sha256(raw.data).hexdigest(),
        "shape": list(array.shape),
        "dtype": array.dtype.name,
    }


def arrays_in_memory(arrays: Mapping[str, Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    """Return the arrays of a record that are in memory."""
    candidates = {name: _in_memory.get(_key(recorded)) for name, recorded in arrays.items()}
    return {name: array for name, array in candidates.items() if array is not None}


def hold(array: NDArray[Any], recorded: Mapping[str, Any]) -> None:
    """Remember that an array is the recorded one, as long as it is in memory."""
    _in_memory[_key(recorded)] = array


def remember(array: NDArray[Any], chunks: bytes, recorded: Mapping[str, Any]) -> None:
    """Remember that an array is the recorded one, and the checksums of its chunks."""
    hold(array, recorded)
    remember_chunks(chunks, recorded)


def remember_chunks(chunks: bytes, recorded: Mapping[str, Any]) -> None:
    """Remember the chunk checksums of an array that was compared or written."""
    _chunks[_key(recorded)] = chunks


def is_unchanged(array: NDArray[Any], chunks: bytes, recorded: Mapping[str, Any]) -> bool:
    """Return whether an array has the recorded form, and its chunks the remembered checksums."""
    form = array.dtype.name, list(array.shape)
    return form == (recorded["dtype"], recorded["shape"]) and _chunks.get(_key(recorded)) == chunks


def _key(recorded: Mapping[str, Any]) -> str:
    """Return checksum, dtype and shape of a recorded array as one key."""
    return f"{recorded['sha256']} {recorded['dtype']} {recorded['shape']}"
