"""A stored group as it is read, and compared with what its record holds.

Results that have most of their arrays in common lie in one group, each with arrays of its own beside these: a
result is the group without what belongs to others.
"""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from sweep import compared, zarr_form
from sweep.location import Location

Recorded = Mapping[str, Mapping[str, Any]]
"""What a record holds of the arrays of a group: sha256, shape and dtype by their names."""


class DamagedError(Exception):
    """A stored group is not what its record says: an array is missing, torn or altered."""


MEMBER = "member"
"""Attribute of the arrays that one of several results of a group has for itself, and that result's label."""
_OF_ARRAYS = (MEMBER, "units", "long_name")


def own_key(name: str, member: str | None) -> str:
    """Return the key in a group of an array that a result has for itself."""
    return f"{name}_{member}" if member else name


@dataclass(frozen=True)
class Group:
    """A group before its arrays are decoded: all of it, or one of several results in it.

    Attributes
    ----------
    name
        What an error calls it.
    keys
        Its arrays' keys in the group by their names.
    said
        What Zarr says of its arrays, by their keys.
    objects
        What it consists of, as far as it has been read.
    """

    name: str
    keys: Mapping[str, str]
    said: Mapping[str, Any]
    attributes: dict[str, Any]
    objects: zarr_form.Objects

    @classmethod
    def whole(
        cls, place: Location, prefix: str, name: str, digest: str | None = None, member: str | None = None
    ) -> "Group":
        """Return a group with all its metadata, which have a digest if that is known, and all its arrays.

        Of one with several results the arrays of one alone.
        """
        if member is None:
            objects = place.read_group(prefix)
        else:
            objects = place.read_group(prefix, [zarr_form.METADATA])
            if not objects:
                raise _other_metadata(name)
            with _decoding(name):
                said, attributes = zarr_form.decode_group(bytes(objects[zarr_form.METADATA]))
                keys = [f"{array}/{zarr_form.METADATA}" for array in said]
                for array in _member(member, said, attributes)[0].values():
                    keys += zarr_form.chunk_keys(array, said[array])
            objects = {**objects, **place.read_group(prefix, keys)}
        if digest is not None and metadata_digest(objects) != digest:
            raise _other_metadata(name)
        with _decoding(name):
            attributes = json.loads(objects[zarr_form.METADATA])["attributes"]
            own = {key.rpartition("/")[0]: key for key in objects if key.endswith(f"/{zarr_form.METADATA}")}
            said = {array: json.loads(objects[key]) for array, key in own.items()}
            names, merged = _member(member, said, attributes)
        return cls(name, names, said, merged, objects)

    @classmethod
    def needed(
        cls,
        place: Location,
        prefix: str,
        name: str,
        digest: str,
        known: Mapping[str, NDArray[Any]],
        member: str | None = None,
    ) -> "Group":
        """Return a group whose own metadata have a digest, and of which no arrays are read that are known.

        The metadata of its arrays are not read either: it repeats them.
        """
        objects = dict(place.read_group(prefix, [zarr_form.METADATA]))
        own = bytes(objects.get(zarr_form.METADATA, b""))
        if hashlib.sha256(own).hexdigest() != digest:
            raise _other_metadata(name)
        with _decoding(name):
            said, attributes = zarr_form.decode_group(own)
            keys, merged = _member(member, said, attributes)
            missing = [key for array, key in keys.items() if array not in known]
            chunks = [chunk for key in missing for chunk in zarr_form.chunk_keys(key, said[key])]
        return cls(name, keys, said, merged, objects | dict(place.read_group(prefix, chunks)))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its arrays, compared with nothing."""
        return {name: self._decoded(name)[0] for name in self.keys}

    def check(self, recorded: Recorded) -> None:
        """Compare all arrays with their sha256."""
        for name in self._names(recorded):
            self._compare(name, self._decoded(name)[0], recorded)

    def verified(self, recorded: Recorded, known: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Return its arrays, of which some are known; compare others as far as they have not been before."""
        found = dict(known)
        for name in self._names(recorded):
            if name in known:
                continue
            found[name], chunks = self._decoded(name)
            if not compared.unchanged(found[name], chunks, recorded[name]):
                self._compare(name, found[name], recorded)
            compared.remember(found[name], chunks, recorded[name])
        return found

    def _names(self, recorded: Recorded) -> Iterable[str]:
        if recorded.keys() != self.keys.keys():
            others = ", ".join(sorted(recorded.keys() ^ self.keys.keys()))
            raise DamagedError(f"{self.name}: is recorded, or is there, without the array {others}")
        return self.keys

    def _decoded(self, name: str) -> tuple[NDArray[Any], bytes]:
        with _decoding(self.name):
            key = self.keys[name]
            return zarr_form.decode_array(key, self.said[key], self.objects)

    def _compare(self, name: str, array: NDArray[Any], recorded: Recorded) -> None:
        if compared.checksum(array) != dict(recorded[name]):
            raise DamagedError(f"{self.name}: the array {name} is not the one recorded")


def metadata_digest(objects: zarr_form.Objects) -> str:
    """Return the sha256 over the objects of a group that are no chunks, in order of their keys."""
    digest = hashlib.sha256()
    for key in sorted(objects):
        if key.rpartition("/")[2] == zarr_form.METADATA:
            digest.update(key.encode() + b"\0")
            digest.update(objects[key])
    return digest.hexdigest()


def _member(
    member: str | None, said: Mapping[str, Any], attributes: Mapping[str, Any]
) -> tuple[dict[str, str], dict[str, Any]]:
    """Return a result's arrays' keys by their names, and its attributes; for None those of the group."""
    if member is None:
        return {key: key for key in said}, dict(attributes)
    keys: dict[str, str] = {}
    merged = dict(attributes)
    for key, each in said.items():
        own = each["attributes"]
        if MEMBER not in own:
            keys[key] = key
        elif own[MEMBER] == member:
            keys[key.removesuffix(own_key("", member))] = key
            merged |= {name: value for name, value in own.items() if name not in _OF_ARRAYS}
    return keys, merged


@contextmanager
def _decoding(name: str) -> Iterator[None]:
    """Call a group damaged that cannot be decoded."""
    try:
        yield
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedError(f"{name}: {type(error).__name__}: {error}") from error


def _other_metadata(name: str) -> DamagedError:
    return DamagedError(f"{name}: is missing, or its metadata are not those recorded")
