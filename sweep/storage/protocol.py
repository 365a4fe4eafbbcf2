"""The interface of a place for results: a folder, or a prefix of a bucket.

The engine relies on two guarantees. `create` is durable when it returns, and the first writer wins. `put`
leaves a whole group or nothing. Keys are paths below the location, with slashes.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from zarr.abc.store import Store

Content = bytes | memoryview | tuple[memoryview, bytes]
"""Content of an object: its bytes, or two consecutive parts of them."""
NONE: Mapping[str, str] = MappingProxyType({})


class Location(Protocol):
    """A place for results."""

    address: str

    def read(self, key: str) -> bytes | None:
        """Return the content at a key, or None where there is none."""

    def read_many(self, keys: Iterable[str]) -> Iterator[bytes | None]:
        """Yield the contents at some keys, in their order."""

    def read_group(self, prefix: str, keys: Iterable[str] | None = None) -> Mapping[str, bytes | bytearray]:
        """Return all objects below a prefix, or only some keys, by the key relative to it."""

    def names(self, prefix: str) -> list[str]:
        """Return the names directly below a prefix, folders without their slash; unsorted."""

    def create(self, key: str, content: bytes) -> bool:
        """Write at a key unless it is taken; return whether this content is there now."""

    def create_many(self, contents: Mapping[str, bytes]) -> list[bool]:
        """Create several keys in less time; all are durable when this returns."""

    def ensure(self, key: str, content: bytes) -> None:
        """Make sure that a key whose content never changes exists."""

    def put(self, prefix: str, objects: Mapping[str, Content], same: Mapping[str, str] = NONE) -> int:
        """Write a whole group; `prefix` contains a digest, so a group already there is the same or damaged.

        `same` holds keys of this location that may already have the same content. Returns the number of bytes
        written.
        """

    def remove(self, key: str) -> None:
        """Remove a key, if it exists."""

    def clean(self, prefix: str, older_than_s: float) -> None:
        """Remove unfinished groups of dead writers below a prefix."""

    def zarr(self, prefix: str) -> "Path | Store":
        """Return the group or array at a prefix in a form that Zarr can open."""

    def check(self) -> None:
        """Check that the location can be used, without writing; raise InputError with the reason if not."""
