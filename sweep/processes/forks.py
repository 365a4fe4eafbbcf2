"""One process that has imported everything and loaded the compiled kernels, from which workers are forked.

It prepares while the driver plans. It has one thread only, so forking it is safe. A worker that replaces a
dead one starts at once, and workers share the memory of what they all load. Only this process fills an empty
cache of kernels: two that compile into it at once can crash.

It ends with the driver, and what is forked from it ends with it. Neither takes Ctrl-C or a hang-up, which a
terminal sends to all processes: the driver stops them.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from multiprocessing import forkserver, get_context, resource_tracker
from multiprocessing.connection import Connection
from typing import Any, TypeVar

Result = TypeVar("Result")

STAGES_MODULE = "RAILVIB_STAGES"
"""Environment variable with the module whose kernels are loaded."""
DRIVER = "RAILVIB_DRIVER"
"""Environment variable with the number of the process that starts one."""
THREADS = {
    "NUMBA_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
"""Environment of worker processes; numba and BLAS read it when they are imported."""
POSSIBLE = sys.platform == "linux"
"""Whether forking is available and safe."""
_SERVER = "sweep.workers.server"
"""What the process imports; by name only, as workers know this room and not the other way round."""
_started = False


def start(stages: str) -> None:
    """Start the process, which loads the kernels of a module's stages; do not wait for it."""
    global _started
    if not POSSIBLE:
        return
    with _ignore_hang_up():
        resource_tracker.ensure_running()  # started later, it would unblock the signals
    with _environment({**THREADS, STAGES_MODULE: stages, DRIVER: str(os.getpid())}), block_signals():
        forkserver.set_forkserver_preload([_SERVER])
        forkserver.ensure_running()
        _started = True


@contextmanager
def _ignore_hang_up() -> Iterator[None]:
    """Let processes started inside the block ignore hang-ups for good, as they do Ctrl-C.

    After a hang-up a resource tracker would be restarted without knowing what to release, and print
    tracebacks.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, before)


def running() -> bool:
    """Return whether the process has been started; it may not be ready yet."""
    return _started


def submit(function: Callable[..., Result], *arguments: Any) -> Callable[[], Result]:
    """Call a function in a new forked process; the callable that is returned waits for its result."""
    future: Future[Result] = Future()
    # In a thread, because forking waits until the server process is ready.
    threading.Thread(target=_call, args=(future, function, arguments), daemon=True).start()
    return future.result


def _call(future: Future[Result], function: Callable[..., Result], arguments: tuple[Any, ...]) -> None:
    context = get_context("forkserver")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(sender, function, arguments), daemon=True)
    try:
        process.start()
        sender.close()
        error, result = receiver.recv()
        process.join()
    except EOFError:
        future.set_exception(RuntimeError(f"{function.__name__}: its process died; was memory short?"))
    except BaseException as fault:
        future.set_exception(fault)
    else:
        if error is None:
            future.set_result(result)
        else:
            future.set_exception(error)


def _answer(sender: Connection, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """Send the error of a call, or None, and its result."""
    try:
        result = function(*arguments)
    except Exception as error:
        sender.send((error, None))
    else:
        sender.send((None, result))


@contextmanager
def _environment(variables: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables inside the block."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def block_signals() -> Iterator[None]:
    """Shield processes started inside the block from Ctrl-C and hang-ups; ours are delivered afterwards."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGHUP))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
