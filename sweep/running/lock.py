"""One driver per directory: a file that the operating system locks, with a note of host and process.

The system releases the lock when the process ends, however it ends, so neither clocks nor process numbers
decide whether a holder is alive. Some file systems keep locks within one host, and some have none. Therefore
the lock of another host is never taken over, and where there are no locks the file itself serves as one.
"""

import fcntl
import json
import os
import socket
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from railvib.errors import InputError

LOCK = "run.lock"
PATIENCE_S = 1.0
"""How long to try to lock the file [s], as `holder` locks it for an instant."""
_POLL_S = 0.02
_NOTE_BYTES = 4096


@dataclass(frozen=True)
class Holder:
    """A process that runs, or ran, in a directory.

    Attributes
    ----------
    host, pid, since
        Where it runs, and when it took the lock; None where its note cannot be read.
    alive
        Whether it runs; None where that cannot be seen from this host.
    """

    host: str | None = None
    pid: int | None = None
    since: str | None = None
    alive: bool | None = None

    def __str__(self) -> str:
        """Return process and host in words."""
        return "an unknown process" if self.pid is None else f"process {self.pid} on {self.host}"


def holder(directory: Path) -> Holder | None:
    """Return who holds the lock of a directory, dead or alive, or None where nobody does.

    Raises
    ------
    InputError
        If run.lock is not a file.
    """
    try:
        descriptor = _open(directory / LOCK, os.O_RDONLY)
    except (FileNotFoundError, NotADirectoryError):
        return None
    try:
        return _holder(descriptor, _lock(descriptor, fcntl.LOCK_SH))
    finally:
        os.close(descriptor)


@contextmanager
def hold(directory: Path) -> Iterator[Holder | None]:
    """Hold the lock of a directory; yield the dead process whose lock was taken over, if any.

    Raises
    ------
    InputError
        If a process holds it that is alive, or cannot be seen from this host, or if run.lock is not a file.
    """
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / LOCK
    descriptor, predecessor = _acquire(path)
    try:
        note = {"host": socket.gethostname(), "pid": os.getpid(), "since": _now()}
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, json.dumps(note).encode() + b"\n", 0)
        yield predecessor
    finally:
        if _is_at(path, descriptor):  # else a user removed it, and another driver may have created a new one
            path.unlink()
        os.close(descriptor)


def _acquire(path: Path) -> tuple[int, Holder | None]:
    """Return the locked file, and the dead process that left it, if any."""
    deadline = time.monotonic() + PATIENCE_S
    while True:
        descriptor, is_new = _open_or_create(path)
        locked = _lock(descriptor, fcntl.LOCK_EX)
        other = _holder(descriptor, locked)
        if _is_at(path, descriptor):
            if is_new if locked is None else locked and other.alive is not None:
                return descriptor, None if other.pid is None else other
            if locked is not False or time.monotonic() > deadline:
                os.close(descriptor)
                raise InputError(_refusal(path, other))
        os.close(descriptor)
        time.sleep(_POLL_S)


def _refusal(path: Path, other: Holder) -> str:
    since = f" since {other.since}" if other.since else ""
    advice = "" if other.alive else f", which cannot be seen from here; if it has ended, remove {path}"
    return f"{path.parent}: is in use by {other}{since}{advice}"


def _open_or_create(path: Path) -> tuple[int, bool]:
    """Return the open file, and whether it was not there before."""
    while True:
        try:
            return _open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL), True
        except FileExistsError:
            pass
        try:
            return _open(path, os.O_RDWR), False
        except FileNotFoundError:  # just released: try again
            continue


def _open(path: Path, flags: int) -> int:
    """Open a regular file, following no link and waiting for no other end of a pipe."""
    try:
        descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    except (FileNotFoundError, FileExistsError, NotADirectoryError, PermissionError):
        raise
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; must be a file that railvib makes: remove it") from None
    if stat.S_ISREG(os.fstat(descriptor).st_mode):
        return descriptor
    os.close(descriptor)
    raise InputError(f"{path}: is not a file; remove it")


def _lock(descriptor: int, kind: int) -> bool | None:
    """Lock an open file; return whether nobody else has, or None where the file system has no locks."""
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):  # the latter on some network file systems
        return False
    except OSError:
        return None
    return True


def _holder(descriptor: int, locked: bool | None) -> Holder:
    """Return who left the note in a file, and whether it is alive by whether the file could be locked."""
    try:
        note = json.loads(os.pread(descriptor, _NOTE_BYTES, 0))
        host, pid, since = str(note["host"]), int(note["pid"]), str(note["since"])
    except (ValueError, TypeError, KeyError, RecursionError):
        return Holder(alive=None if locked is None else not locked)
    is_elsewhere = host != socket.gethostname()
    return Holder(host, pid, since, None if locked is None or locked and is_elsewhere else not locked)


def _is_at(path: Path, descriptor: int) -> bool:
    """Return whether an open file is the one that lies at a path."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.lstat())
    except OSError:
        return False


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
