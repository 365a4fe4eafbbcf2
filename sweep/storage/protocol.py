"""The operations that a place for results offers, whatever it is: a folder, or a prefix of a bucket.

The engine rests on their promises. `create` is durable when it returns and the first one stays; what `put`
leaves at its place is whole. Keys are paths below the location, with slashes.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from zarr.abc.store import Store

Content = bytes | memoryview | tuple[memoryview, bytes]
"""Of an object that is put: its bytes, or two parts of them, one after the other."""
NONE: Mapping[str, str] = MappingProxyType({})


class Location(Protocol):
    """A place for results."""

    address: str

    def read(self, key: str) -> bytes | None:
        """Return the content at a key, or None where there is none."""

    def read_many(self, keys: Iterable[str]) -> Iterator[bytes | None]:
        """Yield the contents at some keys, in their order."""

    def read_group(self, prefix: str, keys: Iterable[str] | None = None) -> Mapping[str, bytes | bytearray]:
        """Return everything below a prefix by the rest of the key, or what is at some of these."""

    def names(self, prefix: str) -> list[str]:
        """Return the names of what lies right below a prefix, folders without their slash; unsorted."""

    def create(self, key: str, content: bytes) -> bool:
        """Write at a key unless something is there; return whether this is what stands there now."""

    def create_many(self, contents: Mapping[str, bytes]) -> list[bool]:
        """Do the same at some keys, in less time; all are durable when this returns."""

    def ensure(self, key: str, content: bytes) -> None:
        """See that a key whose content never changes is there."""

    def put(self, prefix: str, objects: Mapping[str, Content], same: Mapping[str, str] = NONE) -> int:
        """Write a whole group; `prefix` names its content, so that what is there is the same or damaged.

        `same` holds keys of this location at which objects of the group may have been put before. Returns
        the bytes that were written.
        """

    def remove(self, key: str) -> None:
        """Remove what is at a key, if anything is."""

    def clean(self, prefix: str, older_than_s: float) -> None:
        """Remove what writers that died have left aside of groups below a first part of keys."""

    def zarr(self, prefix: str) -> "Path | Store":
        """Return the group or array below a prefix for Zarr to read."""

    def check(self) -> None:
        """Check that the location can be used, without writing; raise InputError with the reason if not."""
