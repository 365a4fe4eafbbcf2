"""Dask workers as the engine's crew: processes of this machine, or a cluster that is running already.

Workers are processes of one thread, so that a crash takes one task with it. What is started here listens on
the loopback address only, and answers nobody without the certificate made for the run: on a shared machine
the loopback address is everybody's, and whoever reaches a scheduler runs code as its owner.
"""

import importlib
import logging
import os
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, WorkerPlugin, as_completed
from distributed.client import FutureCancelledError
from distributed.security import Security

from sweep.plan import Task
from sweep.processes import forks
from sweep.running.task import Outcome, Place, execute
from sweep.workers.watch import PATIENCE_MIN, Watch, WorkersLostError

ENVIRONMENT = {**forks.THREADS, "DASK_LOGGING__DISTRIBUTED": "critical"}
"""Environment of worker processes; Dask logs little, as outcomes report what matters."""

SETTINGS: dict[str, Any] = {
    "distributed.scheduler.worker-saturation": 1.0,  # a worker's tasks are suspects when it dies
    "distributed.scheduler.allowed-failures": 1,
    "distributed.scheduler.work-stealing": False,
    "distributed.scheduler.worker-ttl": "120s",  # a worker that does not answer loses its task to another
    "distributed.nanny.pre-spawn-environ": ENVIRONMENT,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.limit": "10s",
    "distributed.admin.low-level-log-length": 100,  # history kept for debugging Dask
    "distributed.comm.timeouts.connect": "30s",
}


LOST_SCHEDULER = "the scheduler does not answer any more"
ASK_S = 1.0
"""Time for which a count of workers is trusted [s]."""
LOOK_S = 5.0
"""Time between counts of workers while a run waits for results [s]."""
_WAKE_S = 0.1


class Workers:
    """The workers of a scheduler, through a client.

    Parameters
    ----------
    client
        Of the scheduler.
    watch
        Told how many workers there are while none of them returns anything.
    most
        Largest number of workers, if known.
    """

    def __init__(self, client: Client, watch: Watch, most: int = 1) -> None:
        self._client = client
        self._watch = watch
        self._most = most
        self._futures: dict[str, str] = {}
        self._completed = as_completed(loop=client.loop, with_results=True, raise_errors=False)
        self._size = 0
        self._asked = -ASK_S

    @property
    def size(self) -> int:
        """Number of tasks that can run at once, counting workers still to come."""
        self._ask(ASK_S)
        return max(self._most, self._size)

    def _ask(self, oldest_s: float) -> None:
        """Ask the scheduler for its workers if the last answer is older than this.

        Raises
        ------
        WorkersLostError
            If it does not answer, or there have been no workers for too long.
        """
        now = time.monotonic()
        if now - self._asked < oldest_s:
            return
        with _answering(self._client):
            threads: dict[str, int] = self._client.nthreads()
        self._size, self._asked = sum(threads.values()), now
        self._watch.see(self._size)

    def processor_seconds(self) -> list[float]:
        """Return the processor time that each worker process has used so far [s]."""
        return list(self._client.run(time.process_time).values())

    def submit(self, tasks: Sequence[Task], place: Place) -> None:
        """Submit tasks; a later attempt gets a new key, as Dask remembers failed keys."""
        again = "" if place.attempt == 1 else f"{place.attempt:04x}"
        keys = {f"{task.key}{again}": task.key for task in tasks}
        self._futures |= keys
        units = [task.units for task in tasks]
        arguments = (list(keys.values()), units, [place] * len(tasks))
        with _answering(self._client):
            self._completed.update(self._client.map(execute, *arguments, key=list(keys), pure=False))

    def outcomes(self) -> Iterator[tuple[str, Outcome | None]]:
        """Wait for at least one task; release its future at once."""
        while not self._completed.has_ready():
            with self._completed.thread_condition:
                self._completed.thread_condition.wait(timeout=_WAKE_S)
            self._ask(LOOK_S)
        for future, result in self._completed.next_batch(block=False):
            if isinstance(_error(result), FutureCancelledError) and self._client.status != "running":
                raise WorkersLostError(LOST_SCHEDULER)
            key = self._futures.pop(future.key)
            future.release()
            yield key, _outcome(key, future, result)


def _outcome(key: str, future: Future[Any], result: Any) -> Outcome | None:
    """Return the outcome of a task from Dask; an exception here comes from the engine or the machine."""
    if isinstance(result, Outcome):
        return result
    error = _error(result)
    if isinstance(error, KilledWorker | FutureCancelledError):
        return None
    return Outcome(key, "failed", error=f"{type(error).__name__}: {error}".partition("\n")[0])


def _error(result: Any) -> Any:
    """Return the exception of a task that failed; Dask hands some over with their traceback."""
    return result[1] if isinstance(result, tuple) else result


@contextmanager
def _answering(client: Client) -> Iterator[None]:
    """Take an error of the connection, or a client that has given up, for the loss of the scheduler."""
    try:
        yield
    except (OSError, TimeoutError, RuntimeError, ValueError) as error:
        if isinstance(error, OSError | TimeoutError) or client.status != "running":
            raise WorkersLostError(LOST_SCHEDULER) from error
        raise


def serving(dashboard: str | None) -> dict[str, Any]:
    """Return the options by which a cluster of Dask's serves its dashboard at HOST:PORT, or none."""
    # Without an address the scheduler would open a well-known port for its health.
    return {
        "dashboard_address": dashboard or "127.0.0.1:0",
        "scheduler_kwargs": {"dashboard": dashboard is not None},
    }


@contextmanager
def local(workers: int, stages: str, dashboard: bool = False) -> Iterator[Workers]:
    """Start workers on this machine, warmed up, and stop them at the end whatever happens.

    Parameters
    ----------
    workers
        How many processes.
    stages
        The module whose stages they will run.
    dashboard
        Whether to serve Dask's dashboard, on the loopback address.
    """
    forks.start(stages)
    forked = {
        "distributed.worker.multiprocessing-method": "forkserver",
        "distributed.nanny.environ": {
            **os.environ,
            **ENVIRONMENT,
        },  # the server process may have been started earlier
    }
    with (
        dask.config.set({**SETTINGS, **(forked if forks.POSSIBLE else {})}),
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            security=Security.temporary(),  # in memory only
            **serving("127.0.0.1:0" if dashboard else None),
            memory_limit=0,  # the plan limits the memory; pausing workers would hide its errors
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster) as client,
    ):
        if dashboard:
            print(f"dashboard at {cluster.dashboard_link}", file=sys.stderr)
        warm_up(client, stages)
        yield Workers(client, Watch("workers on this machine", PATIENCE_MIN))
        with suppress(
            TimeoutError
        ):  # a worker that is just starting would complain aloud about being stopped
            client.wait_for_workers(workers, timeout=10)


@contextmanager
def remote(
    address: str, security: Security | None, stages: str, patience_min: float = PATIENCE_MIN
) -> Iterator[Workers]:
    """Use the workers of a scheduler that is running; wait so long for new ones when all are gone."""
    for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters is raised here
    with dask.config.set(SETTINGS), Client(address, security=security) as client:
        client.wait_for_workers(1)
        warm_up(client, stages)
        yield Workers(client, Watch(f"workers at {address}", patience_min))


class Deaf(WorkerPlugin):
    """Lets workers ignore Ctrl-C, which a terminal sends to all processes: the driver stops them."""

    def setup(self, worker: Any) -> None:
        """Ignore it; plugins run in the main thread, as this call must."""
        with suppress(ValueError):
            signal.signal(signal.SIGINT, signal.SIG_IGN)


class WarmUp(WorkerPlugin):
    """Loads the compiled kernels in every worker before its first task."""

    def __init__(self, stages: str) -> None:
        self._stages = stages

    def setup(self, worker: Any) -> None:
        """Load them."""
        _warm(self._stages)


def warm_up(client: Client, stages: str) -> None:
    """Let one worker fill the compile cache, then all load it: two that compile into it at once can crash."""
    client.register_plugin(Deaf())
    first = next(iter(client.scheduler_info(n_workers=-1)["workers"]))
    client.submit(_warm, stages, workers=[first], pure=False).result()
    client.register_plugin(WarmUp(stages))


def _warm(stages: str) -> None:
    importlib.import_module(stages).warm_up()
