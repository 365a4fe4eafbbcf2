"""What processes of a run need of the machine, checked before any is started."""

import multiprocessing
import resource
import socket
import tempfile
from pathlib import Path

from railvib.errors import InputError

FILES, FILES_PER_WORKER = 40, 10
"""Files that the driver has open, and those of each worker process."""
LONGEST_FOLDER = 70
"""Characters of the folder for temporary files: sockets in it have paths of at most 107."""


def check(workers: int) -> None:
    """Check that this machine lets worker processes be started.

    Raises
    ------
    InputError
        Naming what it is that does not.
    """
    if not Path("/proc/self/stat").exists():
        raise InputError("/proc: is missing; processes cannot be followed without it, use --workers 0")
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    needed = FILES + FILES_PER_WORKER * workers
    if limit < needed:
        raise InputError(f"ulimit -n = {limit}: {workers} workers need at least {needed} open files")
    folder = tempfile.gettempdir()
    if len(folder) > LONGEST_FOLDER:
        raise InputError(
            f"TMPDIR = {folder!r}: has {len(folder)} characters; must have at most {LONGEST_FOLDER}, "
            "as sockets lie there"
        )
    try:
        multiprocessing.get_context("fork").Lock()  # of other contexts it would start the resource tracker
    except OSError as error:
        raise InputError(
            f"/dev/shm: {error.strerror}; processes share locks there, use --workers 0"
        ) from None
    try:
        with socket.create_server(("127.0.0.1", 0)) as server:
            socket.create_connection(server.getsockname(), timeout=2.0).close()
    except OSError as error:
        raise InputError(
            f"127.0.0.1: {error.strerror or error}; workers are reached there, use --workers 0"
        ) from None
