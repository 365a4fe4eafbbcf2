"""Locations by address, a path or s3://BUCKET/PREFIX, and errors common to all of them."""

import errno
import re
from functools import lru_cache
from pathlib import Path

from railvib.errors import InputError
from sweep.storage.folder import Folder
from sweep.storage.protocol import Location

S3 = "s3://"
ABANDONED_S = 24 * 3600.0
"""Age at which temporary files count as abandoned while other writers may be at work [s]."""
_FULL_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_FULL_WORDS = ("No space left on device", "Disk quota exceeded", "File too large")


class NoSpaceError(Exception):
    """A run had to stop because a result could not be written."""


def is_full(error: BaseException) -> bool:
    """Return whether an error means that a disk, a quota or a file size limit is used up.

    Libraries that write files themselves pass on only the system's message.
    """
    if isinstance(error, OSError):
        return error.errno in _FULL_ERRORS
    return isinstance(error, NoSpaceError) or any(words in str(error) for words in _FULL_WORDS)


@lru_cache(64)
def at(address: Path | str) -> Location:
    """Return the location at a path or an address `s3://BUCKET/PREFIX`.

    Raises
    ------
    InputError
        If an address is not one, or the environment holds no credentials for it.
    """
    if not is_bucket(address):
        return Folder(address)
    from sweep.storage.bucket import Bucket

    return Bucket(*_bucket_parts(str(address)))


def is_bucket(address: Path | str) -> bool:
    """Return whether an address is that of a bucket rather than a path."""
    return isinstance(address, str) and address.startswith(S3)


def address(store: str) -> str:
    """Return a user's `--store` as an absolute path or an address.

    Raises
    ------
    InputError
        If it is neither.
    """
    if is_bucket(store):
        return f"{S3}{'/'.join(_bucket_parts(store))}"
    scheme = re.match(r"^([A-Za-z][\w+.-]*)://", store)
    if scheme:
        raise InputError(f"--store = {scheme[0]}…: must be a path or {S3}BUCKET/PREFIX")
    return str(Path(store).absolute())


def _bucket_parts(address: str) -> list[str]:
    """Return the bucket and the parts of the prefix.

    Raises
    ------
    InputError
        If there is no bucket, or something before it may be a secret.
    """
    parts = [part for part in address.removeprefix(S3).split("/") if part]
    if not parts or "@" in parts[0] or ":" in parts[0]:
        raise InputError(f"--store: must be {S3}BUCKET/PREFIX; credentials belong in the environment alone")
    if not re.fullmatch(r"[a-z0-9][a-z0-9.-]{1,61}[a-z0-9]", parts[0]) or re.search(r"[?#]", address):
        raise InputError(
            f"--store = {address!r}: must be {S3}BUCKET/PREFIX, of lower-case letters and digits"
        )
    return parts
