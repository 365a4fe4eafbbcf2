"""One process of a machine compiles at a time: two that write Numba's cache at once can crash."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LOCK = "compiling.lock"


def cache_folder() -> Path:
    """Return where a user's programs keep what they can make again."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "railvib"


@contextmanager
def alone() -> Iterator[None]:
    """Wait until no other process of this user compiles inside such a block, and keep others waiting."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
