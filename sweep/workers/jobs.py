"""Workers on the machines that a cluster file names: here, by SSH, or as jobs of a batch system.

The scheduler runs in the driver. Where workers may be elsewhere, what goes between them is encrypted, with
a certificate made for the run, which the workers find in the results directory.
"""

import logging
import shlex
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import asyncssh
import dask
from distributed import Client, LocalCluster, Scheduler, SpecCluster
from distributed.core import Status
from distributed.deploy import ssh
from distributed.security import Security

from railvib.errors import InputError
from sweep.processes import forks
from sweep.workers import dask_cluster as cluster
from sweep.workers import drain, tls
from sweep.workers.cluster_file import LOOPBACK, ClusterFile, Local, Queue, Ssh
from sweep.workers.leftovers import FOLDER
from sweep.workers.watch import PATIENCE_MIN, Watch

with patch("signal.signal"):  # on import it would make Ctrl-C end the process as a success
    import dask_jobqueue

SCALING = {"interval": "1s", "target_duration": "1s"}
"""How often the number of workers is adapted, and the work that is worth another worker."""
POLL_S = 0.2
SYSTEMS: dict[str, type[dask_jobqueue.JobQueueCluster]] = {
    "slurm": dask_jobqueue.SLURMCluster,
    "pbs": dask_jobqueue.PBSCluster,
    "lsf": dask_jobqueue.LSFCluster,
    "sge": dask_jobqueue.SGECluster,
    "oar": dask_jobqueue.OARCluster,
    "moab": dask_jobqueue.MoabCluster,
    "htcondor": dask_jobqueue.HTCondorCluster,
}
ACCOUNT = {"slurm": "account", "pbs": "account", "moab": "account"}
"""Option of dask-jobqueue for the account; `project` for all others."""


def check(file: ClusterFile) -> None:
    """Check that jobs can be submitted from this machine.

    Raises
    ------
    InputError
        If the program that submits jobs is missing.
    """
    if isinstance(file, Queue):
        command = SYSTEMS[file.kind].job_cls.submit_command
        if shutil.which(command) is None:
            raise InputError(f"kind = {file.kind!r}: {command}, which hands in jobs, is not on this machine")


@contextmanager
def crew(
    file: ClusterFile,
    directory: Path,
    tasks: int,
    stages: str,
    dashboard: bool,
    patience_min: float | None = None,
) -> Iterator[cluster.Workers]:
    """Start scheduler and workers, and stop them at the end whatever happens.

    Parameters
    ----------
    file
        The checked cluster file.
    directory
        The results directory, which the machines of all workers see.
    tasks
        How many there are to run.
    stages
        The module whose stages they are of.
    dashboard
        Whether to serve Dask's dashboard, on the loopback address where the file names none.
    patience_min
        How long to wait for workers when there are none, minutes; None for the usual time, and for ever for
        the first job in a queue.
    """
    folder = directory.resolve() / FOLDER
    served = file.dashboard or (f"{LOOPBACK}:0" if dashboard else None)
    first = _First()
    with ExitStack() as stack:
        stack.enter_context(dask.config.set(cluster.SETTINGS))
        if isinstance(file, Local):
            dask_cluster = stack.enter_context(_local(file, served))
        else:
            security = stack.enter_context(tls.temporary(folder))
            listening = _listening(file, security, served)
            if isinstance(file, Ssh):
                dask_cluster = stack.enter_context(_ssh(file, listening, security))
            else:
                options = job_options(file, folder, security)
                system = SYSTEMS[file.kind]
                dask_cluster = stack.enter_context(
                    system(
                        job_cls=_telling(system.job_cls, first),
                        scheduler_options=listening,
                        silence_logs=logging.CRITICAL,
                        **options,
                    )
                )
        if isinstance(file, Ssh):
            most = len(file.hosts) * file.workers_per_host
        else:
            most = min(file.maximum_workers, max(tasks, file.minimum_workers))
            dask_cluster.adapt(minimum=file.minimum_workers, maximum=most, **SCALING)
        client = stack.enter_context(Client(dask_cluster))
        if served:
            print(f"dashboard at {dask_cluster.dashboard_link}", file=sys.stderr)
        if isinstance(file, Queue):
            print(f"waiting for the first job of {file.kind}", file=sys.stderr, flush=True)
            client.register_plugin(drain.Drain(file.walltime_minutes * 60.0, file.drain_minutes * 60.0))
        patience = PATIENCE_MIN if patience_min is None and not isinstance(file, Queue) else patience_min
        first.wait(client, Watch(f"the first worker of kind {file.kind}", patience))
        cluster.warm_up(client, stages)
        yield cluster.Workers(client, Watch(f"workers of kind {file.kind}", patience), most)


def _telling(job: type[dask_jobqueue.core.Job], first: "_First") -> type[dask_jobqueue.core.Job]:
    """Return a class of jobs that reports refusal by the batch system; Dask would retry for ever."""

    class Telling(job):  # type: ignore[misc]
        async def start(self) -> None:
            try:
                await super().start()
            except RuntimeError as error:
                lines = [line for line in str(error).partition("stderr:")[2].splitlines() if line]
                first.refusal = lines[0] if lines else str(error)
                self.status = Status.failed
                if not first.awaited:
                    raise

    return Telling


class _First:
    """The first worker, for which a run in a long queue may wait for hours."""

    def __init__(self) -> None:
        self.awaited = True
        self.refusal: str | None = None

    def wait(self, client: Client, watch: Watch) -> None:
        """Wait until it is there, its job is refused, or the wait takes too long."""
        while not client.nthreads():
            if self.refusal is not None:
                raise InputError(f"--cluster: a job is refused: {self.refusal}")
            watch.see(0)
            time.sleep(POLL_S)
        self.awaited = False


def _local(file: Local, dashboard: str | None) -> LocalCluster:
    """Return a cluster of processes on this machine."""
    return LocalCluster(
        n_workers=file.minimum_workers,
        threads_per_worker=1,
        host=file.host or LOOPBACK,
        interface=file.interface,
        security=Security.temporary(),
        **cluster.serving(dashboard),
        memory_limit=0,
        silence_logs=logging.CRITICAL,
    )


def _listening(file: Ssh | Queue, security: Security, dashboard: str | None) -> dict[str, Any]:
    """Return the scheduler's options."""
    place = {"interface": file.interface} if file.interface else {"host": file.host or LOOPBACK}
    return {
        **place,
        "protocol": "tls://",
        "security": security,
        "dashboard": dashboard is not None,
        "dashboard_address": dashboard or f"{LOOPBACK}:0",
    }


def _here_only(file: Ssh | Queue) -> bool:
    """Return whether scheduler and workers are to be reached from this machine only."""
    return file.host is None and file.interface is None


def job_options(file: Queue, folder: Path, security: Security) -> dict[str, Any]:
    """Return the options of dask-jobqueue for a job's script."""
    options: dict[str, Any] = {
        "cores": file.workers_per_job,
        "processes": file.workers_per_job,
        "memory": f"{file.memory_gb} GB",
        "security": security,
        "interface": file.interface,
        "job_name": "railvib",
        "log_directory": str(folder),
        "python": file.python or sys.executable,
        "worker_extra_args": ["--no-dashboard", *_listens_at(file)],
        "job_script_prologue": [
            *file.prologue,
            f"export {drain.STARTED}=$(date +%s)",
            *(f"export {name}={value}" for name, value in forks.THREADS.items()),
        ],
        "job_extra_directives": list(file.directives),
    }
    if file.kind == "htcondor":
        pairs = (line.split("=", 1) for line in file.directives)
        return options | {
            "job_extra_directives": {key.strip(): value.strip() for key, value in pairs},
            "disk": "1 GB",
        }
    if file.kind == "oar":
        options["memory_per_core_property_name"] = "not_applicable"  # sites differ in this: see directives
    options["walltime"] = _walltime(file)
    if file.queue:
        options["queue"] = file.queue
    if file.account:
        options[ACCOUNT.get(file.kind, "project")] = file.account
    return options


def _listens_at(file: Queue) -> list[str]:
    """Return where a job's worker listens, which without a word is on every interface of its machine."""
    if _here_only(file):
        return ["--host", LOOPBACK]
    if file.host is None:
        return []  # dask-jobqueue passes the interface on
    # In backticks: HTCondor takes $(…) for a macro of its own.
    python = shlex.quote(file.python or sys.executable)
    return ["--host", f"`{python} -m sweep.workers.route {shlex.quote(file.host)}`"]


def _walltime(file: Queue) -> str:
    """Return the walltime as HH:MM:SS, or HH:MM where the system knows no seconds."""
    minutes, seconds = divmod(round(60.0 * file.walltime_minutes), 60)
    text = f"{minutes // 60:02d}:{minutes % 60:02d}"
    return text if file.kind == "lsf" else f"{text}:{seconds:02d}"


@contextmanager
def _ssh(file: Ssh, listening: dict[str, Any], security: Security) -> Iterator[SpecCluster]:
    """Start workers by SSH, and the scheduler here."""
    connection = {
        "username": file.user,
        "port": file.port,
        "client_keys": file.key_file,
        "known_hosts": file.known_hosts,
    }
    options: dict[str, Any] = {"nthreads": 1, "memory_limit": 0, "dashboard": False}
    if file.interface:
        options["interface"] = file.interface
    if _here_only(file):
        options["host"] = LOOPBACK
    workers = {
        host: {
            "cls": ssh.Worker,
            "options": {
                "address": host,
                "connect_options": {name: value for name, value in connection.items() if value is not None},
                "kwargs": {**options, "n_workers": file.workers_per_host},
                "remote_python": file.python,
            },
        }
        for host in file.hosts
    }
    # Workers inherit our settings; Dask learns from their log that they have started.
    files = security.get_tls_config_for_role("worker")
    with dask.config.set(
        {
            "distributed.comm.require-encryption": True,
            "distributed.comm.tls.ca-file": files["ca_file"],
            "distributed.comm.tls.worker.cert": files["cert"],
            "distributed.comm.tls.worker.key": files["key"],
            "distributed.nanny.pre-spawn-environ": forks.THREADS,
        }
    ):
        try:
            ssh_cluster = SpecCluster(
                workers,
                {"cls": Scheduler, "options": listening},
                security=security,
                silence_logs=logging.CRITICAL,
            )
        except (OSError, asyncssh.Error) as error:
            raise InputError(f"hosts: {', '.join(file.hosts)}: no workers by SSH: {error}") from None
    with ssh_cluster:
        yield ssh_cluster
