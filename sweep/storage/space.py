"""Whether writing failed for want of space, which is nobody's fault and ends a run without loss."""

import errno

_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_WORDS = ("No space left on device", "Disk quota exceeded", "File too large")


class NoSpaceError(Exception):
    """A run had to stop because a result could not be written."""


def exhausted(error: BaseException) -> bool:
    """Return whether an error says that a disk, a quota or the size allowed to a file is used up.

    Libraries that write files themselves pass on the system's words only.
    """
    if isinstance(error, OSError):
        return error.errno in _ERRORS
    return isinstance(error, NoSpaceError) or any(words in str(error) for words in _WORDS)
