"""Workers on this machine that stop answering."""

import os
import signal
import time

import psutil
import pytest

from sweep.workers import dask_cluster


@pytest.mark.slow
def test_a_worker_that_does_not_answer_loses_its_tasks_and_ends_with_the_run(monkeypatch):
    monkeypatch.setitem(dask_cluster.SETTINGS, "distributed.scheduler.worker-ttl", "4s")
    with dask_cluster.local(2, "tests.sweep.toy") as workers:
        client = workers._client
        stopped, _other = client.run(os.getpid).values()
        futures = [client.submit(time.sleep, 0.5 + 1e-6 * number, pure=False) for number in range(8)]
        os.kill(stopped, signal.SIGSTOP)
        client.gather(futures)
    for _ in range(100):
        if not psutil.pid_exists(stopped):
            return
        time.sleep(0.1)
    raise AssertionError("the stopped process outlives the run")
