"""Who runs in a directory: a file that names host and process, and is recognised when they have died.

The file is linked to its name whole, so that one of several wins, on network file systems as well. Whether a
process lives can be told on its own host only: the lock of another host is left to the person who knows.
"""

import fcntl
import json
import os
import socket
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

import psutil

from railvib.errors import InputError

LOCK = "run.lock"
_CLOCK_S = 2.0
"""By how much two readings of the moment at which a process began may differ."""


@dataclass(frozen=True)
class Holder:
    """A process that runs, or ran, in a directory.

    Attributes
    ----------
    process_began
        Seconds since 1970, by which a later process of the same number is told apart.
    since
        When it took the lock.
    """

    host: str
    pid: int
    process_began: float
    since: str

    @property
    def here(self) -> bool:
        """Whether it is of this host, so that one can tell whether it lives."""
        return self.host == socket.gethostname()

    @property
    def gone(self) -> bool:
        """Whether it is known to have ended."""
        if not self.here:
            return False
        try:
            process = psutil.Process(self.pid)
            another: bool = abs(process.create_time() - self.process_began) > _CLOCK_S
            return another or process.status() == psutil.STATUS_ZOMBIE
        except psutil.NoSuchProcess:
            return True

    def __str__(self) -> str:
        """Return host and process in words."""
        return f"process {self.pid} on {self.host}"


def holder(directory: Path) -> Holder | None:
    """Return who holds the lock of a directory, dead or alive, or None where nobody does."""
    try:
        return _read(directory / LOCK)
    except FileNotFoundError:
        return None


@contextmanager
def held(directory: Path) -> Iterator[Holder | None]:
    """Hold the lock of a directory; yield the dead process whose lock was taken over, if any.

    Raises
    ------
    InputError
        If a process holds it that lives, or that cannot be seen from here; or if that process is dead but the
        file system does not let its lock be taken over.
    """
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / LOCK
    mine = Holder(socket.gethostname(), os.getpid(), psutil.Process().create_time(), _now())
    predecessor = None
    while not _link(path, mine):
        other = holder(directory)
        if other is None:
            continue
        if not other.gone:
            raise InputError(f"{directory}: is in use by {other} since {other.since}{_advice(other, path)}")
        if _remove(path, other):
            predecessor = other
    try:
        yield predecessor
    finally:
        path.unlink(missing_ok=True)


def _advice(other: Holder, path: Path) -> str:
    if other.here:
        return ""
    return f", which cannot be seen from {socket.gethostname()}; if it runs no more, remove {path}"


def _link(path: Path, mine: Holder) -> bool:
    """Put the lock in place unless there is one; return whether that was done."""
    aside = _aside(path)
    try:
        aside.write_text(json.dumps(asdict(mine)) + "\n", encoding="utf-8")
        os.link(aside, path)
    except FileExistsError:
        return False
    finally:
        aside.unlink(missing_ok=True)
    return True


def _remove(path: Path, dead: Holder) -> bool:
    """Take away the lock of a dead process, unless another has taken its place; return whether that was done.

    Only processes of this host do so, one at a time: each locks the very file that it means to take away, so
    that the lock of a living one stays where it is all the while.
    """
    try:
        with path.open("rb+") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            if not os.path.samestat(os.fstat(file.fileno()), path.stat()) or _parsed(file.read()) != dead:
                return False
            path.unlink()
    except FileNotFoundError:
        return False
    except OSError as fault:
        raise InputError(
            f"{path}: is the lock of {dead}, which runs no more, but cannot be taken over "
            f"({fault.strerror}); remove it"
        ) from fault
    return True


def _read(path: Path) -> Holder:
    return _parsed(path.read_bytes())


def _parsed(content: bytes) -> Holder:
    return Holder(**json.loads(content))


def _aside(path: Path) -> Path:
    return path.with_name(f".{path.name}.{uuid.uuid4().hex}.partial")


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
