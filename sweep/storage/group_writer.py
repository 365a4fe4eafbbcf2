"""Writing results as immutable Zarr groups.

`sweep.storage.fields` decides which fields of a dataclass are arrays; all others become attributes. Results
that share most of their arrays, such as the transfer functions of several receivers, can be stored in one
group. Their own arrays are stacked along a new dimension, each result in its own chunks. A group is encoded
in memory, named after its content, and never changes. Only `sweep.storage.codec` cuts arrays into chunks, so
no caller can write part of a chunk.
"""

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from sweep.storage import checksums, codec, fields, location, records
from sweep.storage.fields import Result
from sweep.storage.group import MEMBERS, metadata_digest
from sweep.storage.protocol import Content
from sweep.storage.store import GROUP_FIELDS, STORE

CHUNK_BYTES = 64 * 2**20
"""Size above which an array is cut into chunks."""
_DIGITS = 16
"""Hexadecimal digits of the digest in a group's name."""
_EMPTY_GROUP = b'{"zarr_format":3,"node_type":"group","attributes":{}}'


@dataclasses.dataclass(frozen=True)
class Written:
    """A stored result, as its record needs it.

    Attributes
    ----------
    group
        Name of its group in the store.
    member
        Label of the result in the group; None if it is the whole group.
    arrays
        Per array its sha256, shape and dtype.
    metadata
        The sha256 of all Zarr metadata of the group and of its arrays.
    group_metadata
        The sha256 of the group's metadata, which repeat those of its arrays.
    attributes
        Its attributes, as they are read.
    values
        Its arrays, by name.
    bytes_written
        Its share of the bytes written for the group; linked arrays do not count.
    """

    group: str
    member: str | None
    arrays: dict[str, dict[str, Any]]
    metadata: str
    group_metadata: str
    attributes: dict[str, Any]
    values: Mapping[str, NDArray[Any]]
    bytes_written: int

    def group_fields(self) -> dict[str, Any]:
        """Return the fields of its record by which it is read and compared."""
        return {name: getattr(self, name) for name in GROUP_FIELDS}


@dataclasses.dataclass
class _Stored:
    """Where a shared part was stored, with metadata, chunks and checksums of its arrays."""

    prefix: str
    heads: dict[str, bytes]
    chunks: dict[str, Mapping[str, Content]]
    checksums: dict[str, dict[str, Any]]
    shared: bool = False
    """Whether several groups contain it."""


@dataclasses.dataclass
class _Encoded:
    """The encoded arrays of a group.

    Attributes
    ----------
    heads, chunks
        Metadata and chunks of each array.
    checksums
        Checksums of the arrays that all results of the group share.
    member_checksums
        Checksums of each result's own arrays, by label.
    same
        Keys of objects of other groups with the same content, by keys of this one.
    fresh
        Shared parts that are in no other group yet.
    """

    heads: dict[str, bytes] = dataclasses.field(default_factory=dict)
    chunks: dict[str, Mapping[str, Content]] = dataclasses.field(default_factory=dict)
    checksums: dict[str, dict[str, Any]] = dataclasses.field(default_factory=dict)
    member_checksums: dict[str | None, dict[str, dict[str, Any]]] = dataclasses.field(default_factory=dict)
    same: dict[str, str] = dataclasses.field(default_factory=dict)
    fresh: list[fields.Part] = dataclasses.field(default_factory=list)

    def encode(self, part: fields.Part) -> None:
        """Add the arrays of a part that is in no other group."""
        for key, (array, metadata) in part.arrays.items():
            self.heads[key], self.chunks[key] = codec.encode_array(key, array, metadata, CHUNK_BYTES)
            self.checksums[key] = checksums.checksum(array)
            checksums.remember_chunks(codec.chunk_checksums(self.chunks[key]), self.checksums[key])

    def link(self, stored: _Stored) -> None:
        """Add the arrays of a part that is in another group."""
        self.heads |= stored.heads
        self.chunks |= stored.chunks
        self.checksums |= stored.checksums
        for key, chunks in stored.chunks.items():
            objects = (f"{key}/{name}" for name in (codec.METADATA, *chunks))
            self.same |= {name: f"{stored.prefix}/{name}" for name in objects}

    def stack(self, members: Mapping[str | None, fields.Parts]) -> None:
        """Add the results' own arrays, those of the same name as one array with a chunk for each result."""
        attributes = {MEMBERS: {label: parts.member.attributes for label, parts in members.items()}}
        first = next(iter(members.values()))
        for key, (_, metadata) in first.member.arrays.items():
            arrays = [parts.member.arrays[key][0] for parts in members.values()]
            form = {**metadata, "dims": (first.dimension, *metadata["dims"]), "attributes": attributes}
            self.heads[key], chunks_by_member = codec.encode_stack(key, arrays, form, CHUNK_BYTES)
            self.chunks[key] = {name: chunk for chunks in chunks_by_member for name, chunk in chunks.items()}
            for label, array, chunks in zip(members, arrays, chunks_by_member, strict=True):
                checksum = checksums.checksum(array)
                checksums.remember_chunks(codec.chunk_checksums(chunks), checksum)
                self.member_checksums.setdefault(label, {})[key] = checksum

    def placement(self, part: fields.Part, prefix: str) -> _Stored:
        """Return where one of its parts was stored."""
        return _Stored(
            prefix,
            {key: self.heads[key] for key in part.arrays},
            {key: self.chunks[key] for key in part.arrays},
            {key: self.checksums[key] for key in part.arrays},
        )


class Writer:
    """Writes results as groups of the store at `home`.

    A part that several results share is encoded and stored once; where the file system can, the other groups
    get hard links. Its place is remembered as long as the part is in memory and, after a call of `settle`, if
    several groups contain it. Equal metadata of arrays are stored once too.
    """

    def __init__(self, home: records.Home) -> None:
        self._home = home
        self._stored: WeakKeyDictionary[Any, _Stored] = WeakKeyDictionary()
        self._heads: dict[bytes, str] = {}
        self._ensured: set[str] = set()

    def __call__(self, name: str, result: Any, attributes: Mapping[str, Any]) -> Written:
        """Write `result`, a frozen dataclass of arrays, as a group of its own, as `together` does.

        Raises
        ------
        ValueError
            Also if an array does not have the dimensions that its field declares.
        """
        (written,) = self.together(name, {None: fields.split(result)}, attributes)
        return written

    def together(
        self, name: str, results: Mapping[str | None, fields.Parts], attributes: Mapping[str, Any]
    ) -> list[Written]:
        """Write results that agree in `Parts.group_key` as one group.

        The group's name ends with a digest of its content. So writers whose results differ in the last digit
        never touch each other's groups, and a record names exactly one content.

        Parameters
        ----------
        name
            First part of the group's name.
        results
            The results by their labels; None is the label of one that is the whole group.
        attributes
            Attributes of the group, beside those of the results.

        Raises
        ------
        ValueError
            If an attribute cannot be stored, or results share different things.
        """
        first, *others = results.values()
        alone = None in results or first.dimension is None
        if any(alone or parts.group_key != first.group_key for parts in others):
            raise ValueError(f"{name}: results of one group differ in what is not their own")
        group = _Encoded()
        for part in first.shared:
            self._add(group, part)
        if alone:
            group.encode(first.member)
        array_heads = dict(group.heads)  # metadata that arrays of other groups may share
        if not alone:
            group.stack(results)
        for key, head in array_heads.items():
            if head in self._heads:
                group.same.setdefault(f"{key}/{codec.METADATA}", self._heads[head])
        common = {**attributes, **(first.attributes if alone else first.shared_attributes)}
        group_head = codec.encode_group(group.heads, codec.encode_attributes(common))
        heads = {codec.METADATA: group_head}
        heads |= {f"{key}/{codec.METADATA}": head for key, head in group.heads.items()}
        digest = metadata_digest(heads)
        content = json.dumps([group.checksums, list(group.member_checksums.values()), digest], sort_keys=True)
        place = f"{name}-{hashlib.sha256(content.encode()).hexdigest()[:_DIGITS]}"
        size = self._put(f"{STORE}/{place}", heads, group)
        for key, head in array_heads.items():
            self._heads.setdefault(head, f"{STORE}/{place}/{key}/{codec.METADATA}")
        return [
            Written(
                group=place,
                member=label,
                arrays=group.checksums | group.member_checksums.get(label, {}),
                metadata=digest,
                group_metadata=hashlib.sha256(group_head).hexdigest(),
                attributes={**attributes, **parts.attributes},
                values={key: array for key, (array, _) in parts.arrays.items()},
                bytes_written=size // len(results) + (number < size % len(results)),
            )
            for number, (label, parts) in enumerate(results.items())
        ]

    def _add(self, group: _Encoded, part: fields.Part) -> None:
        """Add a shared part to a group."""
        stored = self._stored.get(part.source)
        if stored is None:
            group.encode(part)
            group.fresh.append(part)
        else:
            stored.shared = True
            group.link(stored)

    def _put(self, prefix: str, heads: Mapping[str, bytes], group: _Encoded) -> int:
        """Write a group, and remember where its shared parts are; return the bytes written."""
        place = location.at(self._home)
        for level in _above(prefix):
            if level not in self._ensured:  # so that readers can walk the store from its root
                place.ensure(f"{level}/{codec.METADATA}", _EMPTY_GROUP)
                self._ensured.add(level)
        objects: dict[str, Content] = {**heads}
        for key, chunks in group.chunks.items():
            objects |= {f"{key}/{name}": chunk for name, chunk in chunks.items()}
        written = place.put(prefix, objects, group.same)
        for part in group.fresh:
            self._stored[part.source] = group.placement(part, prefix)
        return written

    def settle(self) -> None:
        """Forget parts that only one group contains so far: their chunks take as much memory again."""
        for part in [part for part, stored in self._stored.items() if not stored.shared]:
            del self._stored[part]


def _above(key: str) -> list[str]:
    """Return the keys of the groups above one, the root first."""
    parts = key.split("/")[:-1]
    return ["/".join(parts[:number]) for number in range(1, len(parts) + 1)]


def write(home: records.Home, name: str, result: Any, attributes: Mapping[str, Any]) -> Written:
    """Write one result as `Writer` does."""
    return Writer(home)(name, result, attributes)


def restore(written: Written, result_type: type[Result]) -> Result:
    """Return a written result as it would be read back, from its arrays in memory."""
    arrays = checksums.arrays_in_memory(written.arrays)
    for name, recorded in written.arrays.items():
        if name not in arrays:
            arrays[name] = _as_read(written.values[name])
            checksums.hold(arrays[name], recorded)
    return fields.restore(result_type, arrays, written.attributes, written.arrays)


def _as_read(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array as it would be read back: Numba compiles again for other layouts."""
    array = np.ascontiguousarray(array, array.dtype.newbyteorder("=")).reshape(array.shape)
    return array if array.flags.writeable else array.copy()
