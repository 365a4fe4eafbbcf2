"""A stored group as it is read, and compared with what its record holds.

Results that share most of their arrays are stored in one group. The values of one receiver are a slice of an
array with one more dimension. A result is the group without the slices of other results.
"""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from sweep.storage import checksums, codec
from sweep.storage.fields import Recorded
from sweep.storage.protocol import Location


class DamagedError(Exception):
    """A stored group is not what its record says: an array is missing, torn or altered."""


MEMBERS = "members"
"""Attribute of stacked arrays: the attributes of each result, by its label.
"""


@dataclass(frozen=True)
class Group:
    """A group before its arrays are decoded: all of it, or one of several results in it.

    Attributes
    ----------
    name
        Its name in error messages.
    metadata
        Zarr metadata of its arrays, by their names.
    attributes
        Its attributes.
    objects
        Its objects, as far as they have been read.
    """

    name: str
    metadata: Mapping[str, Any]
    attributes: dict[str, Any]
    objects: codec.Objects

    @classmethod
    def read_whole(
        cls, place: Location, prefix: str, name: str, digest: str | None = None, member: str | None = None
    ) -> "Group":
        """Read all metadata and arrays of a group, or of one member of it.

        The metadata are compared with their digest if it is given.
        """
        if member is None:
            objects = place.read_group(prefix)
        else:
            objects = place.read_group(prefix, [codec.METADATA])
            if not objects:
                raise _other_metadata(name)
            with _decoding(name):
                group_metadata, attributes = codec.decode_group(bytes(objects[codec.METADATA]))
                keys = [f"{array}/{codec.METADATA}" for array in group_metadata]
                for array, array_metadata in _member(member, group_metadata, attributes)[0].items():
                    keys += codec.chunk_keys(array, array_metadata)
            objects = {**objects, **place.read_group(prefix, keys)}
        if digest is not None and metadata_digest(objects) != digest:
            raise _other_metadata(name)
        with _decoding(name):
            attributes = json.loads(objects[codec.METADATA])["attributes"]
            metadata = {
                key.rpartition("/")[0]: json.loads(objects[key])
                for key in objects
                if key.endswith(f"/{codec.METADATA}")
            }
            metadata, attributes = _member(member, metadata, attributes)
        return cls(name, metadata, attributes, objects)

    @classmethod
    def read_unknown(
        cls,
        place: Location,
        prefix: str,
        name: str,
        digest: str,
        known: Mapping[str, NDArray[Any]],
        member: str | None = None,
    ) -> "Group":
        """Read a group whose metadata have this digest, without the arrays that are known.

        The metadata of its arrays are not read: the group's metadata repeat them.
        """
        objects = dict(place.read_group(prefix, [codec.METADATA]))
        group_metadata = bytes(objects.get(codec.METADATA, b""))
        if hashlib.sha256(group_metadata).hexdigest() != digest:
            raise _other_metadata(name)
        with _decoding(name):
            metadata, attributes = _member(member, *codec.decode_group(group_metadata))
            missing = [array for array in metadata if array not in known]
            keys = [key for array in missing for key in codec.chunk_keys(array, metadata[array])]
        return cls(name, metadata, attributes, objects | dict(place.read_group(prefix, keys)))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its arrays without comparing them."""
        return {name: self._decode(name)[0] for name in self.metadata}

    def check(self, recorded: Recorded) -> None:
        """Compare all arrays with their sha256."""
        for name in self._names(recorded):
            self._compare(name, self._decode(name)[0], recorded)

    def verify(self, recorded: Recorded, known: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Return its arrays, including the known ones; compare those not compared before."""
        arrays = dict(known)
        for name in self._names(recorded):
            if name in known:
                continue
            array, chunks = self._decode(name)
            if not checksums.is_unchanged(array, chunks, recorded[name]):
                self._compare(name, array, recorded)
            checksums.remember(array, chunks, recorded[name])
            arrays[name] = array
        return arrays

    def _names(self, recorded: Recorded) -> Iterable[str]:
        if recorded.keys() != self.metadata.keys():
            others = ", ".join(sorted(recorded.keys() ^ self.metadata.keys()))
            raise DamagedError(f"{self.name}: is recorded, or is there, without the array {others}")
        return self.metadata

    def _decode(self, name: str) -> tuple[NDArray[Any], bytes]:
        with _decoding(self.name):
            return codec.decode_array(name, self.metadata[name], self.objects)

    def _compare(self, name: str, array: NDArray[Any], recorded: Recorded) -> None:
        if checksums.checksum(array) != dict(recorded[name]):
            raise DamagedError(f"{self.name}: the array {name} is not the one recorded")


def metadata_digest(objects: codec.Objects) -> str:
    """Return the sha256 over the objects of a group that are no chunks, in order of their keys."""
    digest = hashlib.sha256()
    for key in sorted(objects):
        if key.rpartition("/")[2] == codec.METADATA:
            digest.update(key.encode() + b"\0")
            digest.update(objects[key])
    return digest.hexdigest()


def _member(
    label: str | None, metadata: Mapping[str, Any], attributes: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the metadata of a result's arrays, and its attributes; for None those of the whole group."""
    by_array, merged = dict(metadata), dict(attributes)
    if label is None:
        return by_array, merged
    for name, array_metadata in metadata.items():
        members = array_metadata["attributes"].get(MEMBERS)
        if members is None:
            continue
        if label in members:
            by_array[name] = codec.slice_metadata(array_metadata, list(members).index(label))
            merged |= members[label]
        else:
            del by_array[name]
    return by_array, merged


@contextmanager
def _decoding(name: str) -> Iterator[None]:
    """Turn errors of decoding into `DamagedError`."""
    try:
        yield
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedError(f"{name}: {type(error).__name__}: {error}") from error


def _other_metadata(name: str) -> DamagedError:
    return DamagedError(f"{name}: is missing, or its metadata are not those recorded")
