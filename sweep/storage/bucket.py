"""A prefix of an S3 bucket as a location, through object_store's Python binding."""

import os
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from datetime import timedelta
from typing import TYPE_CHECKING

import obstore
from obstore.exceptions import AlreadyExistsError, BaseError
from obstore.store import S3Store

from railvib.errors import InputError
from sweep.storage.protocol import NONE, Content

if TYPE_CHECKING:
    from obstore.store import RetryConfig
    from zarr.abc.store import Store

CONNECTIONS = 16
"""Requests to a bucket at the same time, per process."""
PATIENT: "RetryConfig" = {"max_retries": 10, "retry_timeout": timedelta(minutes=3)}
"""Retries of a bucket that does not answer, before a task fails."""
BRIEF: "RetryConfig" = {"max_retries": 2, "retry_timeout": timedelta(seconds=20)}
"""Retries before a run, while a user waits."""
CREDENTIALS = (
    ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"),
    ("AWS_WEB_IDENTITY_TOKEN_FILE",),
    ("AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",),
    ("AWS_CONTAINER_CREDENTIALS_FULL_URI",),
    ("AWS_SKIP_SIGNATURE",),
)
"""Environment variables that supply credentials; no other source is used."""


class Bucket:
    """A prefix of an S3 bucket; the environment alone holds the credentials and the endpoint."""

    def __init__(self, bucket: str, *prefix: str) -> None:
        self.address = address = f"s3://{'/'.join((bucket, *prefix))}"
        if not any(all(os.environ.get(name) for name in names) for names in CREDENTIALS):
            raise InputError(
                f"--store = {address!r}: no credentials in the environment; set AWS_ACCESS_KEY_ID and "
                "AWS_SECRET_ACCESS_KEY"
            )
        allowed = os.environ.get("AWS_ALLOW_HTTP", "").lower() in ("1", "true")
        if os.environ.get("AWS_ENDPOINT_URL", "").startswith("http://") and not allowed:
            raise InputError(
                f"--store = {address!r}: AWS_ENDPOINT_URL is not encrypted; AWS_ALLOW_HTTP=true allows that"
            )
        self._bucket, self._prefix = bucket, list(prefix)
        self._store = self._open([])
        self._ensured: set[str] = set()

    def _open(self, below: list[str], retries: "RetryConfig" = PATIENT) -> S3Store:
        prefix = "/".join([*self._prefix, *below])
        return S3Store(self._bucket, prefix=prefix or None, retry_config=retries)

    def read(self, key: str) -> bytes | None:
        """Return an object's content."""
        try:
            return bytes(obstore.get(self._store, key).bytes())
        except FileNotFoundError:
            return None

    def read_many(self, keys: Iterable[str]) -> Iterator[bytes | None]:
        """Yield the contents of objects, several requests at a time."""
        with ThreadPoolExecutor(CONNECTIONS) as pool:
            yield from pool.map(self.read, keys)

    def read_group(self, prefix: str, keys: Iterable[str] | None = None) -> Mapping[str, bytes | bytearray]:
        """Return all objects below a prefix, or some of them."""
        if keys is None:
            pages = obstore.list(self._store, prefix)
            keys = [meta["path"].removeprefix(f"{prefix}/") for page in pages for meta in page]
        keys = list(keys)
        contents = zip(keys, self.read_many(f"{prefix}/{key}" for key in keys), strict=True)
        return {key: content for key, content in contents if content is not None}

    def names(self, prefix: str) -> list[str]:
        """Return the last parts of keys and of common prefixes."""
        listing = obstore.list_with_delimiter(self._store, prefix)
        keys = [*listing["common_prefixes"], *(meta["path"] for meta in listing["objects"])]
        return [key.rstrip("/").rpartition("/")[2] for key in keys]

    def create(self, key: str, content: bytes) -> bool:
        """Put an object if the key is free."""
        try:
            obstore.put(self._store, key, content, mode="create", use_multipart=False)
        except AlreadyExistsError:
            # After a lost answer the repeated request finds its own object.
            return self.read(key) == content
        return True

    def create_many(self, contents: Mapping[str, bytes]) -> list[bool]:
        """Put objects whose keys are free, several requests at a time."""
        with ThreadPoolExecutor(CONNECTIONS) as pool:
            return list(pool.map(self.create, contents.keys(), contents.values()))

    def ensure(self, key: str, content: bytes) -> None:
        """Put an object once per process, if it is not there."""
        if key not in self._ensured:
            self.create(key, content)
            self._ensured.add(key)

    def put(self, prefix: str, objects: Mapping[str, Content], same: Mapping[str, str] = NONE) -> int:
        """Put all objects; other writers of this prefix put the same bytes."""
        with ThreadPoolExecutor(CONNECTIONS) as pool:
            return sum(pool.map(lambda key: self._put(f"{prefix}/{key}", objects[key]), objects))

    def _put(self, key: str, content: Content) -> int:
        whole = b"".join(content) if isinstance(content, tuple) else bytes(content)
        obstore.put(self._store, key, whole)
        return len(whole)

    def remove(self, key: str) -> None:
        """Delete an object; a missing one counts as deleted."""
        with suppress(FileNotFoundError):
            obstore.delete(self._store, key)

    def clean(self, prefix: str, older_than_s: float) -> None:
        """Do nothing: an object is whole or not there."""

    def zarr(self, prefix: str) -> "Store":
        """Return Zarr's view of a prefix."""
        from zarr.storage import ObjectStore

        return ObjectStore(self._open(prefix.split("/")), read_only=True)

    def check(self) -> None:
        """List one key, which shows whether the bucket exists and grants access."""
        try:
            next(iter(obstore.list(self._open([], BRIEF), chunk_size=1)), None)
        except (BaseError, OSError) as error:
            raise InputError(f"--store = {self.address!r}: {_reason(str(error))}") from None


def _reason(message: str) -> str:
    """Return the reason in a server's or connection's error message, in a few words.

    Codes are matched with their names: bare digits may be part of a port or a time.
    """
    for sign, reason in (
        ("NoSuchBucket", "there is no such bucket"),
        ("403 Forbidden", "the credentials in the environment do not allow to list it"),
        ("401 Unauthorized", "the credentials in the environment are refused"),
        ("error sending request", "the server cannot be reached"),
    ):
        if sign in message:
            return reason
    return message.partition("\n")[0]
