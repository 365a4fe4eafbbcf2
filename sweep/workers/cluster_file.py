"""The cluster file: where workers are to be started, how many, and for how long."""

import re
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, Strict, model_validator

from railvib.errors import InputError
from railvib.parameters.validation import Integer, Number, Parameters, validated
from sweep.study.files import read_toml
from sweep.study.names import Name

Queueing = Literal["slurm", "pbs", "lsf", "sge", "oar", "moab", "htcondor"]
"""Batch systems that dask-jobqueue knows."""

Count = Annotated[Integer, Field(ge=1)]
Text = Annotated[str, Strict(), Field(min_length=1)]
Port = Annotated[Integer, Field(ge=1, le=65535)]
Positive = Annotated[Number, Field(gt=0.0)]
LOOPBACK = "127.0.0.1"


class Scheduler(Parameters):
    """Where scheduler and dashboard listen: on the loopback address unless told otherwise.

    Attributes
    ----------
    host
        Name or address of this machine under which workers reach the scheduler.
    interface
        Network interface of that address instead, on this machine and those of the workers.
    dashboard
        Address HOST:PORT of Dask's dashboard; without it there is none.
    """

    host: Text | None = None
    interface: Text | None = None
    dashboard: Text | None = None

    @model_validator(mode="after")
    def _addresses(self) -> Self:
        if self.host and self.interface:
            raise InputError(f".interface = {self.interface!r}: either host or interface, not both")
        if self.dashboard and not re.fullmatch(r"[\w.-]+:\d+", self.dashboard):
            raise InputError(f".dashboard = {self.dashboard!r}: must be HOST:PORT")
        return self


class Scaled(Scheduler):
    """Workers whose number follows the amount of work; each is a process of one thread."""

    minimum_workers: Count = 1
    maximum_workers: Count

    @model_validator(mode="after")
    def _ascends(self) -> Self:
        if self.minimum_workers > self.maximum_workers:
            raise InputError(
                f".minimum_workers = {self.minimum_workers}: "
                f"must not exceed maximum_workers = {self.maximum_workers}"
            )
        return self


class Local(Scaled):
    """Processes on this machine."""

    kind: Literal["local"]


class Ssh(Scheduler):
    """Processes on machines that can be reached by SSH and see the same files.

    Attributes
    ----------
    hosts
        Names of the machines.
    workers_per_host
        Processes on each.
    user, port, key_file, known_hosts
        Settings of the connection that this user's SSH configuration lacks.
    python
        Interpreter of railvib's environment there; as here if not given.
    """

    kind: Literal["ssh"]
    hosts: Annotated[tuple[Text, ...], Field(min_length=1)]
    workers_per_host: Count = 1
    user: Text | None = None
    port: Port | None = None
    key_file: Text | None = None
    known_hosts: Text | None = None
    python: Text | None = None


class Queue(Scaled):
    """Jobs of a batch system, each with some workers.

    Attributes
    ----------
    workers_per_job
        Processes of a job, and processors it asks for.
    memory_gb
        Memory of a job [GB].
    walltime_minutes
        How long a job may run [min].
    drain_minutes
        How long before the end of its walltime at the latest a worker takes no more tasks [min]; what a
        worker is computing then it finishes.
    queue, account
        As the batch system knows them; Slurm calls a queue a partition.
    directives
        Further lines for the head of the job's script, without the word that begins them.
    prologue
        Lines of shell before the worker starts.
    python
        Interpreter of railvib's environment on the machines of the cluster; as here if not given.
    """

    kind: Queueing
    workers_per_job: Count = 1
    memory_gb: Positive
    walltime_minutes: Positive
    drain_minutes: Positive = 5.0
    queue: Name | None = None
    account: Name | None = None
    directives: tuple[Text, ...] = ()
    prologue: tuple[Text, ...] = ()
    python: Text | None = None

    @model_validator(mode="after")
    def _time_to_work(self) -> Self:
        if 2.0 * self.drain_minutes > self.walltime_minutes:
            raise InputError(
                f".drain_minutes = {self.drain_minutes:g} min: must not exceed half of "
                f"walltime_minutes = {self.walltime_minutes:g} min"
            )
        return self

    @model_validator(mode="after")
    def _whole_jobs(self) -> Self:
        if self.maximum_workers < self.workers_per_job:
            raise InputError(
                f".workers_per_job = {self.workers_per_job}: "
                f"must not exceed maximum_workers = {self.maximum_workers}"
            )
        return self

    @model_validator(mode="after")
    def _known_to_the_system(self) -> Self:
        if self.kind == "htcondor":
            for key in ("queue", "account"):
                if getattr(self, key) is not None:
                    raise InputError(f".{key} = {getattr(self, key)!r}: htcondor has none; use directives")
            for line in self.directives:
                if "=" not in line:
                    raise InputError(f".directives = {line!r}: must be KEY = VALUE for htcondor")
        return self


ClusterFile = Local | Ssh | Queue
MODELS: dict[str, type[Local] | type[Ssh] | type[Queue]] = {
    "local": Local,
    "ssh": Ssh,
    **dict.fromkeys(("slurm", "pbs", "lsf", "sge", "oar", "moab", "htcondor"), Queue),
}


def load(path: Path) -> ClusterFile:
    """Read and check a cluster file.

    Raises
    ------
    InputError
        With one line that names the key, its value and what is allowed.
    """
    data = read_toml(path)
    kind = data.get("kind")
    if kind not in MODELS:
        fault = "is missing" if kind is None else "is unknown"
        raise InputError(f"{path}: kind = {kind!r}: {fault}; must be one of {', '.join(MODELS)}")
    try:
        return validated(MODELS[str(kind)], data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
