"""The bytes of a Zarr group (version 3) of small arrays, each in chunks of whole rows without compression.

A chunk lies beside its array's metadata, as `c.0.0`, so a group has one folder per array. Groups with one
folder per dimension, from earlier versions of railvib, can be read as well.

All objects of a group are encoded and decoded here in memory. The zarr library runs an event loop for each
object, which for groups of a few hundred kilobytes takes ten times as long as everything else in storing a
result. The tests open the groups with the zarr library, as other readers do.
"""

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import ceil, prod
from typing import Any

import google_crc32c
import numpy as np
from numpy.typing import NDArray

from sweep.storage.protocol import Content

_CODECS = [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}]
"""No compression, as complex fields do not compress; the checksum reveals a torn chunk to any reader."""
_CRC_BYTES = 4
_ENCODER = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":"))
_PLACE = "place"
"""Key of slice metadata: the index of the array in its stack."""
_SEPARATOR = "."
"""Separator in chunk keys. A slash, the format's default, would add two folders per array."""

METADATA = "zarr.json"
"""Key of the metadata of a group or an array, below its own."""
_GROUP = (
    b'{"zarr_format":3,"node_type":"group","attributes":%b,'
    b'"consolidated_metadata":{"kind":"inline","must_understand":false,"metadata":{%b}}}'
)


Objects = Mapping[str, bytes | bytearray | memoryview]
"""Of a group or an array, by their keys below its own."""


def encode_array(
    name: str, array: NDArray[Any], metadata: Mapping[str, Any], chunk_bytes: int
) -> tuple[bytes, dict[str, Content]]:
    """Return the metadata of an array, and its chunks.

    Parameters
    ----------
    metadata
        `dims`, and `unit`, `description` and further `attributes` if it has them.
    chunk_bytes
        Size above which the array is cut along its first dimension.
    """
    shape = _chunk_shape(array, chunk_bytes)
    form = _array_metadata(name, array.shape, array.dtype, shape, metadata)
    return _json(form), _chunks(array, shape, ())


def encode_stack(
    name: str, arrays: Sequence[NDArray[Any]], metadata: Mapping[str, Any], chunk_bytes: int
) -> tuple[bytes, list[dict[str, Content]]]:
    """Return the metadata of arrays of one form along a new first dimension, and the chunks of each.

    Parameters are those of `encode_array`; the first of `dims` is the new dimension. Chunks are views of the
    arrays where they can be.
    """
    first = arrays[0]
    shape = _chunk_shape(first, chunk_bytes)
    form = _array_metadata(name, (len(arrays), *first.shape), first.dtype, [1, *shape], metadata)
    return _json(form), [_chunks(array, shape, (place,), view=True) for place, array in enumerate(arrays)]


def slice_metadata(metadata: Mapping[str, Any], place: int) -> dict[str, Any]:
    """Return metadata with which `chunk_keys` and `decode_array` take one array of a stack alone."""
    grid = metadata["chunk_grid"]
    grid = {**grid, "configuration": {"chunk_shape": grid["configuration"]["chunk_shape"][1:]}}
    return {
        **metadata,
        "shape": metadata["shape"][1:],
        "chunk_grid": grid,
        _PLACE: [*metadata.get(_PLACE, []), place],
    }


def chunk_checksums(chunks: Mapping[str, Content]) -> bytes:
    """Return the checksums of encoded chunks, as `decode_array` does."""
    every = (chunk[1] if isinstance(chunk, tuple) else chunk[-_CRC_BYTES:] for chunk in chunks.values())
    return b"".join(every)


def encode_attributes(attributes: Mapping[str, Any]) -> bytes:
    """Return the attributes of a group as JSON.

    Raises
    ------
    TypeError, ValueError
        If an attribute cannot be stored.
    """
    return _json(dict(attributes))


def encode_group(arrays: Mapping[str, bytes], attributes: bytes) -> bytes:
    """Return the metadata of a group from those of its arrays and from encoded attributes."""
    # The arrays' metadata are repeated: consolidated metadata, which xarray looks for.
    repeated = b",".join(b"%b:%b" % (_quote(name), array) for name, array in arrays.items())
    return _GROUP % (attributes, repeated)


@lru_cache(32)
def decode_group(content: bytes) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """Return the consolidated metadata of a group's arrays by name, and its attributes.

    Cached for the next results of the same group.

    Raises
    ------
    ValueError, KeyError, TypeError
        If it is not in the form of `encode_group`.
    """
    group = json.loads(content)
    return group["consolidated_metadata"]["metadata"], group["attributes"]


def chunk_keys(name: str, metadata: Mapping[str, Any]) -> list[str]:
    """Return the keys of an array's chunks below the group's."""
    separator = metadata["chunk_key_encoding"]["configuration"]["separator"]
    shape = metadata["chunk_grid"]["configuration"]["chunk_shape"]
    return [f"{name}/{key}" for key in _keys(metadata["shape"], shape, metadata.get(_PLACE, ()), separator)]


def decode_array(name: str, metadata: Mapping[str, Any], objects: Objects) -> tuple[NDArray[Any], bytes]:
    """Return an array of a group, and the checksums of its chunks, which are verified.

    Raises
    ------
    ValueError, KeyError, TypeError
        If a chunk is missing, torn, or encoded in another way than here.
    """
    if metadata["codecs"] != _CODECS:
        raise ValueError(f"{name}: is encoded in another way")
    shape, dtype = tuple(metadata["shape"]), np.dtype(metadata["data_type"]).newbyteorder("<")
    chunk_shape = metadata["chunk_grid"]["configuration"]["chunk_shape"]
    if 0 in shape:
        return np.empty(shape, dtype), b""
    if list(chunk_shape[1:]) != list(shape[1:]):  # a stack of arrays that are themselves cut into chunks
        slices = (decode_array(name, slice_metadata(metadata, place), objects) for place in range(shape[0]))
        arrays, checksums = zip(*slices, strict=True)
        return np.stack(arrays), b"".join(checksums)
    parts = [_verify(key, objects) for key in chunk_keys(name, metadata)]
    content = parts[0][0] if len(parts) == 1 else np.concatenate([chunk for chunk, _ in parts])
    array = np.frombuffer(content, dtype).reshape((-1, *chunk_shape[1:]) if shape else ())
    # For read-only arrays Numba would compile kernels again.
    array = (array[: shape[0]] if shape else array).astype(dtype.newbyteorder("="), copy=False)
    return array if array.flags.writeable else array.copy(), b"".join(checksum for _, checksum in parts)


def _array_metadata(
    name: str,
    shape: Sequence[int],
    dtype: np.dtype[Any],
    chunk_shape: Sequence[int],
    metadata: Mapping[str, Any],
) -> dict[str, Any]:
    return {
        "zarr_format": 3,
        "node_type": "array",
        "shape": list(shape),
        "data_type": dtype.name,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(chunk_shape)}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": _SEPARATOR}},
        "fill_value": _fill(dtype),
        "codecs": _CODECS,
        "attributes": {
            "units": metadata.get("unit", "1"),
            "long_name": metadata.get("description", name),
            **metadata.get("attributes", {}),
        },
        "dimension_names": list(metadata["dims"]),
        "storage_transformers": [],
    }


def _chunk_shape(array: NDArray[Any], chunk_bytes: int) -> list[int]:
    """Return the chunk shape: the whole array, or whole rows of it where it is larger."""
    shape = [max(size, 1) for size in array.shape]
    if array.nbytes > chunk_bytes and shape:
        shape[0] = max(1, chunk_bytes // (array.nbytes // array.shape[0]))
    return shape


def _fill(dtype: np.dtype[Any]) -> Any:
    """Return the fill value for missing chunks: NaN, or zero for types without NaN."""
    return {"c": ["NaN", "NaN"], "f": "NaN", "b": False}.get(dtype.kind, 0)


def _keys(
    shape: Sequence[int], chunk_shape: Sequence[int], place: Sequence[int], separator: str
) -> list[str]:
    """Return the keys of an array's chunks below its own, in order of their rows; `place` is in a stack."""
    start = ["c", *map(str, place)]
    if not shape:
        return [separator.join(start)]
    number = 0 if 0 in shape else ceil(shape[0] / chunk_shape[0])
    return [separator.join((*start, str(index), *("0" for _ in shape[1:]))) for index in range(number)]


def _chunks(
    array: NDArray[Any], shape: Sequence[int], place: Sequence[int], view: bool = False
) -> dict[str, Content]:
    """Return the chunks of an array, or of one of a stack, by their keys below its own."""
    chunks: dict[str, Content] = {}
    for number, key in enumerate(_keys(array.shape, shape, place, _SEPARATOR)):
        rows = array[number * shape[0] : (number + 1) * shape[0]] if shape else array
        chunks[key] = _chunk(rows, shape, view)
    return chunks


def _chunk(rows: NDArray[Any], shape: Sequence[int], view: bool) -> Content:
    """Return a chunk's bytes and their checksum; a partial chunk is padded, as the format demands."""
    dtype = rows.dtype.newbyteorder("<")
    if view and rows.dtype == dtype and rows.flags.c_contiguous and rows.shape == tuple(shape):
        data = rows.reshape(-1).view(np.uint8)
        return data.data, _crc(data)
    content = np.empty(dtype.itemsize * prod(shape) + _CRC_BYTES, np.uint8)
    data = content[:-_CRC_BYTES]
    chunk = data.view(dtype).reshape(shape)
    if shape:
        chunk[: len(rows)] = rows
        chunk[len(rows) :] = 0
    else:
        chunk[...] = rows
    content[-_CRC_BYTES:] = np.frombuffer(_crc(data), np.uint8)
    return content.data


def _verify(key: str, objects: Objects) -> tuple[NDArray[np.uint8], bytes]:
    """Verify the checksum of a chunk; return its bytes and the checksum."""
    content = np.frombuffer(objects[key], np.uint8)
    chunk, stored = content[:-_CRC_BYTES], content[-_CRC_BYTES:].tobytes()
    if _crc(chunk) != stored:
        raise ValueError(f"{key}: is torn or altered")
    return chunk, stored


def _crc(data: NDArray[np.uint8]) -> bytes:
    checksum: int = google_crc32c.value(data)
    return checksum.to_bytes(_CRC_BYTES, "little")


@lru_cache(256)
def _quote(name: str) -> bytes:
    return _json(name)


def _json(value: Any) -> bytes:
    return _ENCODER.encode(value).encode()
