"""Launching a run: in this process, in processes started here, or on the workers of a cluster."""

import importlib
import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from railvib.errors import InputError
from sweep.processes import forks, surroundings
from sweep.workers.watch import PATIENCE_MIN

if TYPE_CHECKING:
    from distributed.security import Security

    from sweep.running.scheduler import Crew
    from sweep.workers.cluster_file import ClusterFile

STAGES = "railvib.stages"
"""Module of the product's stages, see `sweep.unit`."""

Argument = TypeVar("Argument")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Launch:
    """A user's settings for where a run computes.

    Attributes
    ----------
    workers
        Processes to start on this machine, by default one per processor; 0 computes in this process.
    scheduler
        Address of a Dask scheduler to use instead.
    tls_ca, tls_cert, tls_key
        Files of certificates for it.
    cluster
        File that says where to start workers instead.
    dashboard
        Whether a scheduler started here shows Dask's dashboard.
    wait
        Minutes to wait for workers when there are none; None for the usual time.

    Raises
    ------
    InputError
        If settings exclude each other, or one is wrong.
    """

    workers: int | None = None
    scheduler: str | None = None
    tls_ca: str | None = None
    tls_cert: str | None = None
    tls_key: str | None = None
    cluster: Path | None = None
    dashboard: bool = False
    wait: float | None = None

    def __post_init__(self) -> None:
        """Check the settings without connecting to anything."""
        places = [
            f"--{name}" for name in ("workers", "scheduler", "cluster") if getattr(self, name) is not None
        ]
        if len(places) > 1:
            raise InputError(f"{' and '.join(places)}: exclude each other")
        for name in ("tls_ca", "tls_cert", "tls_key"):
            if getattr(self, name) is not None and self.scheduler is None:
                raise InputError(f"--{name.replace('_', '-')}: is for --scheduler tls://HOST:PORT")
        if self.wait is not None and self.scheduler is None and self.cluster is None:
            raise InputError("--wait: is for the workers of --scheduler or --cluster")
        if self.dashboard and self.scheduler is not None:
            raise InputError("--dashboard: a scheduler that is running has its own")
        _ = self.file  # check it even if it is not needed

    @property
    def processes(self) -> int:
        """Number of processes to start on this machine."""
        return (os.cpu_count() or 1) if self.workers is None else self.workers

    @property
    def local_processes(self) -> int | None:
        """Number of processes that compute on this machine; None if other machines do."""
        return None if self.scheduler is not None or self.cluster is not None else max(self.processes, 1)

    @cached_property
    def file(self) -> "ClusterFile | None":
        """The content of the cluster file."""
        if self.cluster is None:
            return None
        from sweep.workers import cluster_file

        return cluster_file.load(self.cluster)

    @cached_property
    def security(self) -> "Security | None":
        """The certificates for a scheduler that asks for some."""
        if self.scheduler is None or not self.scheduler.startswith("tls://"):
            return None
        from sweep.workers import tls

        certificates = tls.Certificates(self.tls_ca, self.tls_cert, self.tls_key)
        certificates.check()
        return certificates.security()

    @property
    def _starts_processes(self) -> bool:
        """Whether processes are started on this machine."""
        return self.scheduler is None and self.file is None and self.processes > 0

    def get_ready(self, stages: str) -> None:
        """Start to prepare local workers; do not wait.

        Raises
        ------
        InputError
            If this machine does not let them be started.
        """
        if self._starts_processes:
            surroundings.check(self.processes)
            forks.start(stages)

    def beside(self, function: Callable[[Argument], Result], argument: Argument) -> Callable[[], Result]:
        """Call a function in a process that has loaded the kernels, or here if there is none.

        So the driver does not load them, nor compile them while another process does. The callable that is
        returned waits for the result.
        """
        if self._starts_processes and forks.POSSIBLE:
            waiting = forks.submit(function, argument)
            importlib.import_module(
                "sweep.workers.dask_cluster"
            )  # needed next, and the other process is not ready yet
            return waiting
        result = function(argument)
        return lambda: result

    def check(self, directory: Path, store: str | None) -> None:
        """Check that workers can be started or reached, before anything is written.

        Parameters
        ----------
        directory
            Where results will go.
        store
            Path or address of the shared store, if there is one.

        Raises
        ------
        InputError
            If they cannot, with the reason.
        """
        if self.scheduler is not None:
            from sweep.workers import reach

            reach.check(self.scheduler, self.security, directory, store)
        if self.file is not None:
            from sweep.workers import jobs

            jobs.check(self.file)

    def crew(self, tasks: int, stages: str, directory: Path) -> "AbstractContextManager[Crew]":
        """Return the crew that runs a number of tasks, with the stages of a module.

        Workers started for it are stopped at the end, whatever happens.
        """
        if self.scheduler is None and self.file is None and self.processes == 0:
            return _alone()
        from sweep.workers import dask_cluster as cluster

        if self.scheduler is not None:
            patience = PATIENCE_MIN if self.wait is None else self.wait
            return cluster.remote(self.scheduler, self.security, stages, patience)
        if self.file is not None:
            from sweep.workers import jobs

            return jobs.crew(self.file, directory, tasks, stages, self.dashboard, self.wait)
        return cluster.local(min(self.processes, tasks), stages, self.dashboard)


@contextmanager
def _alone() -> Iterator["Crew"]:
    """Compute in this process, which needs its memory for the results afterwards."""
    from sweep.running import scheduler as engine
    from sweep.running import task

    yield engine.ThisProcess()
    task.forget()
