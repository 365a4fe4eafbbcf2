"""One allocation of Slurm for a whole run of scheduler, driver and workers, one per rank.

Started as `srun --ntasks=N scripts/slurm-allocation STUDY [options of railvib run]`. The ranks meet in a
folder that only this user can read, in the directory from which they were started: there lie, while the
scheduler runs, its address and the certificate with which all that goes between the ranks is encrypted.
"""

import logging
import os
import shutil
import signal
import socket
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from unittest.mock import patch

import dask
from distributed.core import rpc
from distributed.security import Security

from railvib import cli
from railvib.errors import InputError
from sweep.workers import tls
from sweep.workers.cluster_file import LOOPBACK
from sweep.workers.dask_cluster import SETTINGS
from sweep.workers.leftovers import CERTIFICATE, KEY

with patch("signal.signal"):  # on import it would make Ctrl-C end the process as a success
    from dask_jobqueue.slurm import SLURMRunner

SCHEDULER, DRIVER = 0, 1
FEWEST = 3
ADDRESS_FILE = "scheduler.json"
POLL_S = 0.2
PATIENCE_S = 300.0
"""How long ranks wait for the scheduler: they may start minutes apart."""
TERMINATION_S = 2.0
"""How long the driver tries to reach a scheduler that it wants to end, and that may have ended."""


class Runner(SLURMRunner):  # type: ignore[misc]
    """Scheduler, driver or worker, as it falls to this rank, over encrypted connections.

    Made in the scheduler's rank or a worker's, it returns when the run is over.
    """

    def __init__(self, meeting: Path, security: Security) -> None:
        self._security = security
        alone = os.environ.get("SLURM_NNODES", "1") == "1"
        options: dict[str, Any] = {"security": security, "dashboard": False}
        if alone:
            options["host"] = LOOPBACK
        listening = {"protocol": "tls://", "dashboard_address": f"{LOOPBACK}:0", "host": socket.gethostname()}
        super().__init__(
            scheduler_file=str(meeting / ADDRESS_FILE),
            scheduler_options=listening | options,
            worker_class="distributed.Nanny",  # a crash takes the task, not the rank
            worker_options={"nthreads": 1, "memory_limit": 0, **options},
        )

    async def before_client_start(self) -> None:
        """Prepare to end the scheduler; the parent's connection has no certificate."""
        encryption = self._security.get_connection_args("client")  # type: ignore[no-untyped-call]
        self.scheduler_comm = rpc(  # type: ignore[no-untyped-call]
            self.scheduler_address, timeout=TERMINATION_S, connection_args=encryption
        )

    async def _close(self) -> None:
        with suppress(OSError):  # the scheduler has ended already
            await super()._close()


def main(arguments: Sequence[str]) -> None:
    """Do what falls to this rank; the driver's exit status is the program's.

    Raises
    ------
    InputError
        If this is no rank of an allocation, there are too few, or the scheduler does not come up.
    """
    try:
        rank, ranks = int(os.environ["SLURM_PROCID"]), int(os.environ["SLURM_NTASKS"])
        meeting = Path(f".railvib-{os.environ['SLURM_JOB_ID']}.{os.environ['SLURM_STEP_ID']}")
    except KeyError as missing:
        raise InputError(f"{missing.args[0]}: is not set; start with srun --ntasks=N") from None
    if ranks < FEWEST:
        raise InputError(f"--ntasks = {ranks}: must be at least {FEWEST}: scheduler, driver and a worker")
    for number in (signal.SIGINT, signal.SIGTERM):  # the runner ends itself by the first one
        signal.signal(number, lambda *_: sys.exit())
    for library in ("distributed", "tornado"):
        logging.getLogger(library).setLevel(logging.CRITICAL)
    with dask.config.set(SETTINGS):
        if rank == SCHEDULER:
            _schedule(meeting)
        elif rank == DRIVER:
            _drive(meeting, arguments)
        else:
            _work(meeting)


def _schedule(meeting: Path) -> None:
    """Run the scheduler until the driver ends it."""
    meeting.mkdir(mode=0o700)
    try:
        with tls.temporary(meeting) as security:
            Runner(meeting, security)
    finally:
        shutil.rmtree(meeting, ignore_errors=True)


def _drive(meeting: Path, arguments: Sequence[str]) -> None:
    """Run the study, and end the scheduler whatever happens."""
    _await_scheduler(meeting)
    with Runner(meeting, tls.security_of(meeting)) as runner:
        certificate, key = str(meeting / CERTIFICATE), str(meeting / KEY)
        options = ["--scheduler", runner.scheduler_address, "--tls-ca", certificate]
        options += ["--tls-cert", certificate, "--tls-key", key]
        cli.main(["run", *arguments, *options], prog_name="railvib")


def _work(meeting: Path) -> None:
    """Run a worker until the scheduler ends."""
    _await_scheduler(meeting)
    try:
        Runner(meeting, tls.security_of(meeting))
    except RuntimeError as error:
        if (meeting / ADDRESS_FILE).exists():  # or the run was over before this worker was there
            raise InputError(f"rank {os.environ['SLURM_PROCID']}: {error}") from None


def _await_scheduler(meeting: Path) -> None:
    """Wait until the scheduler has left its address."""
    deadline = time.monotonic() + PATIENCE_S
    while not (meeting / ADDRESS_FILE).exists():
        if time.monotonic() > deadline:
            raise InputError(f"{meeting}: the scheduler has not come up within {PATIENCE_S:g} s")
        time.sleep(POLL_S)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        print(f"Error: {error}", file=sys.stderr)
        sys.exit(2)
