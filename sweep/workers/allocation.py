"""One allocation of Slurm for a whole run of scheduler, driver and workers, one per rank.

Started as `srun --ntasks=N scripts/slurm-allocation STUDY [options of railvib run]`. The ranks meet in a
folder that only this user can read, in the directory from which they were started: there lie the scheduler's
address and, while it runs, the certificate with which all that goes between the ranks is encrypted.
"""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from railvib.errors import InputError
from sweep.processes.forks import THREADS
from sweep.workers import tls
from sweep.workers.cluster_file import LOOPBACK
from sweep.workers.dask_cluster import SETTINGS

SCHEDULER, DRIVER = 0, 1
FEWEST = 3
TOLD = "scheduler.json"
ENDED = "ended"
POLL_S = 0.2
PATIENCE_S = 300.0
"""How long ranks wait for the scheduler: they may start minutes apart."""
DASK = [sys.executable, "-m", "dask"]


def main(arguments: Sequence[str]) -> int:
    """Do what falls to this rank; return its exit status.

    Raises
    ------
    InputError
        If this is no rank of an allocation, or there are too few.
    """
    try:
        rank, ranks = int(os.environ["SLURM_PROCID"]), int(os.environ["SLURM_NTASKS"])
        name = f".railvib-{os.environ['SLURM_JOB_ID']}.{os.environ['SLURM_STEP_ID']}"
    except KeyError as missing:
        raise InputError(f"{missing.args[0]}: is not set; start with srun --ntasks=N") from None
    if ranks < FEWEST:
        raise InputError(f"--ntasks = {ranks}: must be at least {FEWEST}: scheduler, driver and a worker")
    meeting = Path.cwd() / name
    alone = os.environ.get("SLURM_NNODES", "1") == "1"
    if rank == SCHEDULER:
        return _schedule(meeting, alone)
    if rank == DRIVER:
        return _drive(meeting, arguments)
    return _work(meeting, alone)


def _schedule(meeting: Path, alone: bool) -> int:
    """Run the scheduler until the driver has ended."""
    meeting.mkdir(mode=0o700)
    try:
        with tls.temporary(meeting):
            command = [*DASK, "scheduler", "--protocol", "tls", "--port", "0", "--no-dashboard"]
            command += ["--host", LOOPBACK if alone else socket.gethostname()]
            command += ["--scheduler-file", str(meeting / TOLD), *_files(meeting)]
            with subprocess.Popen(command, env={**os.environ, **_settings()}) as scheduler:
                while not (meeting / ENDED).exists() and scheduler.poll() is None:
                    time.sleep(POLL_S)
                scheduler.terminate()
    finally:
        shutil.rmtree(meeting, ignore_errors=True)
    return 0


def _drive(meeting: Path, arguments: Sequence[str]) -> int:
    """Run the study, and let the scheduler end."""
    address = json.loads(_await(meeting / TOLD).read_text())["address"]
    command = [
        sys.executable,
        "-c",
        "from railvib.cli import main; main(prog_name='railvib')",
        "run",
        *arguments,
    ]
    command += ["--scheduler", address, "--tls-ca", str(meeting / tls.CERTIFICATE)]
    command += ["--tls-cert", str(meeting / tls.CERTIFICATE), "--tls-key", str(meeting / tls.KEY)]
    try:
        return subprocess.run(command, check=False).returncode
    finally:
        (meeting / ENDED).touch()


def _work(meeting: Path, alone: bool) -> int:
    """Run a worker until the scheduler ends."""
    command = [*DASK, "worker", "--nthreads", "1", "--no-dashboard"]
    command += ["--host", LOOPBACK] if alone else []
    command += ["--scheduler-file", str(_await(meeting / TOLD)), *_files(meeting)]
    return subprocess.run(command, env={**os.environ, **THREADS}, check=False).returncode


def _files(meeting: Path) -> list[str]:
    """Return the options for the certificate, the same in all roles."""
    certificate, key = str(meeting / tls.CERTIFICATE), str(meeting / tls.KEY)
    return ["--tls-ca-file", certificate, "--tls-cert", certificate, "--tls-key", key]


def _settings() -> dict[str, str]:
    """Return Dask's settings for a scheduler of our own as variables of the environment."""
    return {
        f"DASK_{name.upper().replace('.', '__').replace('-', '_')}": str(value)
        for name, value in SETTINGS.items()
        if name.startswith("distributed.scheduler.")
    }


def _await(path: Path) -> Path:
    """Wait until another rank has left a file."""
    deadline = time.monotonic() + PATIENCE_S
    while not path.exists():
        if time.monotonic() > deadline:
            raise InputError(f"{path}: the scheduler has not come up within {PATIENCE_S:g} s")
        time.sleep(POLL_S)
    return path


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except InputError as error:
        print(f"Error: {error}", file=sys.stderr)
        sys.exit(2)
