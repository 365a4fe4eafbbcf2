"""Workers that a cluster file asks for: on this machine, by SSH, and those that leave before their time."""

import os
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import asyncssh
import dask
import psutil
import pytest

from railvib.errors import InputError
from sweep import plan
from sweep.running import scheduler
from sweep.running.task import Place
from sweep.storage import records
from sweep.workers import drain, jobs
from sweep.workers.cluster_file import Local, Ssh
from tests.sweep import toy

TASKS = 8


def run(directory, crew, wanted):
    work_plan = plan.make(wanted, records.ids_at(directory))
    return scheduler.run(work_plan, Place(str(directory), "run-1", toy.__name__), crew, lambda *_: None)


def wanted(**more):
    return [toy.square(2 * number, **more) for number in range(TASKS)]


def workers(directory):
    return {record["worker"] for record in records.commits(directory)}


def listening():
    """Return the addresses at which this process and its children listen."""
    family = [psutil.Process(), *psutil.Process().children(recursive=True)]
    found = [item for process in family for item in process.net_connections() if item.status == "LISTEN"]
    return {item.laddr.ip for item in found}


def test_local_workers_come_as_there_is_work_and_listen_on_loopback(tmp_path):
    file = Local(kind="local", minimum_workers=1, maximum_workers=2)
    with jobs.crew(file, tmp_path, TASKS, toy.__name__, dashboard=True) as crew:
        assert crew.size == 2
        assert listening() == {"127.0.0.1"}
        assert run(tmp_path, crew, wanted(sleep=0.5)).done == TASKS
    assert len(workers(tmp_path)) == 2
    assert listening() == set()


def test_ctrl_c_still_interrupts_with_batch_systems_at_hand():
    code = (
        "import signal, sweep.workers.jobs; "
        "assert signal.getsignal(signal.SIGINT) is signal.default_int_handler"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[3])


@pytest.mark.slow
def test_workers_leave_before_their_time_and_finish_what_they_compute(tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    file = Local(kind="local", minimum_workers=1, maximum_workers=1)
    with (
        dask.config.set({"distributed.deploy.lost-worker-timeout": "1s"}),
        jobs.crew(file, tmp_path, TASKS, toy.__name__, dashboard=False) as crew,
    ):
        crew._client.register_plugin(drain.Drain(walltime_s=2.5, drain_s=0.5))
        tally = run(tmp_path, crew, wanted(sleep=0.5, marks=str(marks)))
    assert (tally.done, tally.failed) == (TASKS, 0)
    assert len(workers(tmp_path)) >= 2  # others took their place
    starts = Counter(name.partition("-")[0] for name in os.listdir(marks))
    assert set(starts.values()) == {1}  # and no task was broken off


@pytest.fixture
def server(tmp_path, monkeypatch):
    """Return the folder of an SSH server's files while it runs."""
    # Left by Dask where workers were started before: it silences those that this server starts.
    monkeypatch.delenv("DASK_LOGGING__DISTRIBUTED", raising=False)
    folder = tmp_path / "ssh"
    folder.mkdir()
    with subprocess.Popen([sys.executable, Path(__file__).parents[1] / "ssh_server.py", folder]) as process:
        deadline = time.monotonic() + 30.0
        while not (folder / "port").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        yield folder
        process.terminate()


def by_ssh(server):
    return Ssh(
        kind="ssh",
        hosts=("127.0.0.1",),
        workers_per_host=2,
        user="anybody",
        port=int((server / "port").read_text()),
        key_file=str(server / "key"),
        known_hosts=str(server / "known_hosts"),
    )


@pytest.mark.slow
def test_workers_by_ssh(tmp_path, server):
    with jobs.crew(by_ssh(server), tmp_path, TASKS, toy.__name__, dashboard=False) as crew:
        assert crew.size == 2
        assert run(tmp_path, crew, wanted(sleep=0.1)).done == TASKS
        assert oct((tmp_path / jobs.FOLDER / "key.pem").stat().st_mode)[-3:] == "600"
    assert len(workers(tmp_path)) == 2
    assert list((tmp_path / jobs.FOLDER).iterdir()) == []
    assert "PRIVATE KEY" not in (server / "commands").read_text()


def test_a_key_that_ssh_refuses_is_told(tmp_path, server):
    asyncssh.generate_private_key("ssh-ed25519").write_private_key(server / "key")
    with (
        pytest.raises(InputError, match="no workers by SSH: Permission denied"),
        jobs.crew(by_ssh(server), tmp_path, TASKS, toy.__name__, dashboard=False),
    ):
        pass
