"""Workers of a batch system's jobs leave before their time is up, and first finish what they compute."""

import asyncio
import os
import random
import time
from typing import Any

from distributed import WorkerPlugin
from distributed.core import Status

STARTED = "RAILVIB_JOB_STARTED"
"""Variable in which a job's script leaves the time at which it began, seconds since 1970."""
POLL_S = 0.2


class Drain(WorkerPlugin):
    """Lets a worker take no more tasks some time before its job ends, and go when it has none.

    Dask's own lifetime of workers hands the task that is running to another one, so that it runs twice.

    Parameters
    ----------
    walltime_s
        How long the job may run [s].
    drain_s
        How long before that a worker takes no more tasks at the latest [s]; some do up to twice as early,
        so that not all go at once.
    """

    def __init__(self, walltime_s: float, drain_s: float) -> None:
        self._walltime_s = walltime_s
        self._drain_s = drain_s

    def setup(self, worker: Any) -> None:
        """Set the clock of a worker that starts; one that follows another in a job has less time."""
        age = time.time() - float(os.environ.get(STARTED, time.time()))
        delay_s = self._walltime_s - self._drain_s * random.uniform(1.0, 2.0) - age
        worker.loop.call_later(max(delay_s, 0.0), _leave, worker)


async def _leave(worker: Any) -> None:
    """Take no more tasks, finish those there are, and go for good."""
    worker.memory_manager.memory_pause_fraction = False  # or it would go on where memory allows
    worker.status = Status.paused
    while worker.state.executing or worker.state.in_flight_tasks:
        await asyncio.sleep(POLL_S)
    await worker.close_gracefully(restart=False, reason="end of its job")
