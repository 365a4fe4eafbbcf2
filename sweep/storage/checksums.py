"""Stored arrays against their records, and which of them this process has compared.

An array that somebody holds need not be read again: tables have many in common. One that is read again need
not be hashed again: the checksums that its chunks had when it was written, or its sha256 compared, show
whatever has changed in them since, but for a chance of one in four billion.
"""

import hashlib
from collections.abc import Mapping
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from sweep.storage.cache import Latest

REMEMBERED = 4096
"""Arrays, at a few hundred bytes each, whose chunks' checksums are kept."""

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
    """Return those of the arrays of a record that are in memory."""
    candidates = {name: _in_memory.get(_key(recorded)) for name, recorded in arrays.items()}
    return {name: array for name, array in candidates.items() if array is not None}


def hold(array: NDArray[Any], recorded: Mapping[str, Any]) -> None:
    """Keep in mind that an array is the recorded one, as long as somebody holds it."""
    _in_memory[_key(recorded)] = array


def remember(array: NDArray[Any], chunks: bytes, recorded: Mapping[str, Any]) -> None:
    """Keep in mind that an array is the recorded one, and the checksums of its chunks."""
    hold(array, recorded)
    remember_chunks(chunks, recorded)


def remember_chunks(chunks: bytes, recorded: Mapping[str, Any]) -> None:
    """Keep in mind the checksums of the chunks of an array that has been compared or written."""
    _chunks[_key(recorded)] = chunks


def is_unchanged(array: NDArray[Any], chunks: bytes, recorded: Mapping[str, Any]) -> bool:
    """Return whether an array has the recorded form, and its chunks the checksums that are in mind."""
    form = array.dtype.name, list(array.shape)
    return form == (recorded["dtype"], recorded["shape"]) and _chunks.get(_key(recorded)) == chunks


def _key(recorded: Mapping[str, Any]) -> str:
    """Return the checksum of a record's array with its form as one text."""
    return f"{recorded['sha256']} {recorded['dtype']} {recorded['shape']}"
