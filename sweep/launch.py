"""Who computes a run: this process, processes started here, or the workers of a cluster."""

import os
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sweep.engine import Crew


@dataclass(frozen=True)
class Launch:
    """What a user says about who computes.

    Attributes
    ----------
    workers
        Processes to start on this machine, by default one per processor; 0 computes in this process.
    scheduler
        Address of a Dask scheduler to use instead.
    dashboard
        Whether workers started here show Dask's dashboard.
    """

    workers: int | None = None
    scheduler: str | None = None
    dashboard: bool = False

    @property
    def processes(self) -> int:
        """How many processes to start on this machine."""
        return (os.cpu_count() or 1) if self.workers is None else self.workers

    def crew(self, tasks: int, kinds: str) -> "AbstractContextManager[Crew]":
        """Return who computes so many tasks with the kinds of a module.

        Workers that are started for it are stopped at the end, whatever happens.
        """
        from sweep import engine

        if self.scheduler is None and self.processes == 0:
            return nullcontext(engine.ThisProcess())
        from sweep import cluster

        if self.scheduler is not None:
            return cluster.remote(self.scheduler, kinds)
        return cluster.local(min(self.processes, tasks), kinds, self.dashboard)
