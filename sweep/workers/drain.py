"""Workers in batch jobs finish their task and leave before the job's time is up."""

import asyncio
import os
import random
import time
from typing import Any

from distributed import WorkerPlugin
from distributed.core import Status

STARTED = "RAILVIB_JOB_STARTED"
"""Environment variable with the start of a job, seconds since 1970."""
POLL_S = 0.2


class Drain(WorkerPlugin):
    """Stops a worker from taking tasks some time before its job ends, and lets it leave when idle.

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
        """Set the timer of a new worker; one that replaces another in a job has less time."""
        age = time.time() - float(os.environ.get(STARTED, time.time()))
        delay_s = self._walltime_s - self._drain_s * random.uniform(1.0, 2.0) - age
        worker.loop.call_later(max(delay_s, 0.0), _leave, worker)


async def _leave(worker: Any) -> None:
    """Take no more tasks, finish the present ones, and leave."""
    worker.memory_manager.memory_pause_fraction = False  # else it would resume when memory allows
    worker.status = Status.paused
    while worker.state.executing or worker.state.in_flight_tasks:
        await asyncio.sleep(POLL_S)
    await worker.close_gracefully(restart=False, reason="end of its job")
