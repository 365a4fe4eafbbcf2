"""Who computes a run: this process, processes started here, or the workers of a cluster."""

import importlib
import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from railvib.errors import InputError
from sweep.processes import forks

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
    """What a user says about who computes.

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

    Raises
    ------
    InputError
        If these exclude each other, or are wrong in themselves.
    """

    workers: int | None = None
    scheduler: str | None = None
    tls_ca: str | None = None
    tls_cert: str | None = None
    tls_key: str | None = None
    cluster: Path | None = None
    dashboard: bool = False

    def __post_init__(self) -> None:
        """Check what can be checked without asking anybody."""
        places = [
            f"--{name}" for name in ("workers", "scheduler", "cluster") if getattr(self, name) is not None
        ]
        if len(places) > 1:
            raise InputError(f"{' and '.join(places)}: exclude each other")
        for name in ("tls_ca", "tls_cert", "tls_key"):
            if getattr(self, name) is not None and self.scheduler is None:
                raise InputError(f"--{name.replace('_', '-')}: is for --scheduler tls://HOST:PORT")
        if self.dashboard and self.scheduler is not None:
            raise InputError("--dashboard: a scheduler that is running has its own")
        _ = self.file  # a wrong one is told whether or not it is needed

    @property
    def processes(self) -> int:
        """How many processes to start on this machine."""
        return (os.cpu_count() or 1) if self.workers is None else self.workers

    @property
    def local_processes(self) -> int | None:
        """How many processes compute on this machine; None where others do."""
        return None if self.scheduler is not None or self.cluster is not None else max(self.processes, 1)

    @cached_property
    def file(self) -> "ClusterFile | None":
        """What the cluster file says."""
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
        """Begin with what workers started here need, while there is something else to do; does not wait."""
        if self._starts_processes:
            forks.start(stages)

    def beside(self, function: Callable[[Argument], Result], argument: Argument) -> Callable[[], Result]:
        """Call a function in a process that has loaded the kernels, or here if there is none.

        So the driver need not load them, and does not compile them while another process does. What is
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
        """Ask whoever is to compute whether they can, before anything is written.

        Parameters
        ----------
        directory
            Where results will go.
        store
            Path or address of a store outside, if there is one.

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
        """Return who computes so many tasks with the stages of a module for a results directory.

        Workers that are started for it are stopped at the end, whatever happens.
        """
        if self.scheduler is None and self.file is None and self.processes == 0:
            return _alone()
        from sweep.workers import dask_cluster as cluster

        if self.scheduler is not None:
            return cluster.remote(self.scheduler, self.security, stages)
        if self.file is not None:
            from sweep.workers import jobs

            return jobs.crew(self.file, directory, tasks, stages, self.dashboard)
        return cluster.local(min(self.processes, tasks), stages, self.dashboard)


@contextmanager
def _alone() -> Iterator["Crew"]:
    """Compute in this process, which needs its memory for the results afterwards."""
    from sweep.running import scheduler as engine
    from sweep.running import task

    yield engine.ThisProcess()
    task.forget()
