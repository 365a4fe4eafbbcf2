"""A stored group as it is read, and compared with what its record holds.

Results that have most of their arrays in common lie in one group. What is a result's own, the values of one
receiver, is there part of an array with one dimension more: a result is the group without what others have.
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
"""Attribute of arrays that hold what several results have for themselves, one behind the other: what is said
of each, by its label.
"""


@dataclass(frozen=True)
class Group:
    """A group before its arrays are decoded: all of it, or one of several results in it.

    Attributes
    ----------
    name
        What an error calls it.
    said
        What Zarr says of its arrays, by their names.
    objects
        What it consists of, as far as it has been read.
    """

    name: str
    said: Mapping[str, Any]
    attributes: dict[str, Any]
    objects: codec.Objects

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
            objects = place.read_group(prefix, [codec.METADATA])
            if not objects:
                raise _other_metadata(name)
            with _decoding(name):
                said, attributes = codec.decode_group(bytes(objects[codec.METADATA]))
                keys = [f"{array}/{codec.METADATA}" for array in said]
                for array, each in _member(member, said, attributes)[0].items():
                    keys += codec.chunk_keys(array, each)
            objects = {**objects, **place.read_group(prefix, keys)}
        if digest is not None and metadata_digest(objects) != digest:
            raise _other_metadata(name)
        with _decoding(name):
            attributes = json.loads(objects[codec.METADATA])["attributes"]
            own = {key.rpartition("/")[0]: key for key in objects if key.endswith(f"/{codec.METADATA}")}
            said = {array: json.loads(objects[key]) for array, key in own.items()}
            said, attributes = _member(member, said, attributes)
        return cls(name, said, attributes, objects)

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
        objects = dict(place.read_group(prefix, [codec.METADATA]))
        own = bytes(objects.get(codec.METADATA, b""))
        if hashlib.sha256(own).hexdigest() != digest:
            raise _other_metadata(name)
        with _decoding(name):
            said, attributes = _member(member, *codec.decode_group(own))
            missing = [array for array in said if array not in known]
            keys = [key for array in missing for key in codec.chunk_keys(array, said[array])]
        return cls(name, said, attributes, objects | dict(place.read_group(prefix, keys)))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its arrays, compared with nothing."""
        return {name: self._decoded(name)[0] for name in self.said}

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
            if not checksums.unchanged(found[name], chunks, recorded[name]):
                self._compare(name, found[name], recorded)
            checksums.remember(found[name], chunks, recorded[name])
        return found

    def _names(self, recorded: Recorded) -> Iterable[str]:
        if recorded.keys() != self.said.keys():
            others = ", ".join(sorted(recorded.keys() ^ self.said.keys()))
            raise DamagedError(f"{self.name}: is recorded, or is there, without the array {others}")
        return self.said

    def _decoded(self, name: str) -> tuple[NDArray[Any], bytes]:
        with _decoding(self.name):
            return codec.decode_array(name, self.said[name], self.objects)

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
    label: str | None, said: Mapping[str, Any], attributes: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what is said of a result's arrays, and its attributes; for None those of the whole group."""
    own, merged = dict(said), dict(attributes)
    if label is None:
        return own, merged
    for name, each in said.items():
        members = each["attributes"].get(MEMBERS)
        if members is None:
            continue
        if label in members:
            own[name] = codec.slice_metadata(each, list(members).index(label))
            merged |= members[label]
        else:
            del own[name]
    return own, merged


@contextmanager
def _decoding(name: str) -> Iterator[None]:
    """Call a group damaged that cannot be decoded."""
    try:
        yield
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedError(f"{name}: {type(error).__name__}: {error}") from error


def _other_metadata(name: str) -> DamagedError:
    return DamagedError(f"{name}: is missing, or its metadata are not those recorded")
