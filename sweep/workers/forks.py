"""One process that has imported everything and loaded the compiled kernels, from which workers are forked.

It gets ready while the driver still plans, and has no thread but one, so that forking it is safe. A worker
that replaces a dead one is there at once, and workers share the memory of what they all need. Only this
process compiles where nothing is in the cache yet: two that compile into it at once can crash.
"""

import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import forkserver, get_context
from typing import Any, TypeVar

Result = TypeVar("Result")

KINDS = "RAILVIB_KINDS"
"""Environment variable with the module whose kernels are loaded."""
THREADS = {
    "NUMBA_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
"""Environment of worker processes; numba and BLAS read it when they are imported."""
POSSIBLE = sys.platform == "linux"
"""Elsewhere forking is not, or not safely, to be had."""
_started = False


def start(kinds: str) -> None:
    """Start the process, without waiting for it, to load the kernels of a module's kinds."""
    global _started
    if not POSSIBLE:
        return
    before = dict(os.environ)
    os.environ.update({**THREADS, KINDS: kinds})
    try:
        forkserver.set_forkserver_preload(["sweep.workers.preloaded"])
        forkserver.ensure_running()
        _started = True
    finally:
        os.environ.clear()
        os.environ.update(before)


def running() -> bool:
    """Return whether the process has been started; it may still be getting ready."""
    return _started


def submit(function: Callable[..., Result], *arguments: Any) -> Callable[[], Result]:
    """Call a function in a process forked for it, without waiting; what is returned waits for its result."""

    def call() -> Result:
        with ProcessPoolExecutor(1, mp_context=get_context("forkserver")) as pool:
            return pool.submit(function, *arguments).result()

    caller = ThreadPoolExecutor(1)  # to fork takes until the process from which it is done is ready
    future = caller.submit(call)
    caller.shutdown(wait=False)
    return future.result
