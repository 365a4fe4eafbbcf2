"""The address at which workers of jobs listen."""

import subprocess
from pathlib import Path

import pytest
from distributed.security import Security

from sweep.workers import jobs, route
from sweep.workers.cluster_file import Queue


def test_the_way_to_this_machine_is_its_loopback():
    assert route.address_towards("127.0.0.1") == "127.0.0.1"
    with pytest.raises(OSError, match=r"."):
        route.address_towards("no.such.host.invalid")


@pytest.mark.parametrize("kind", ["slurm", "pbs", "lsf", "sge", "moab"])
@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ({}, "--host 127.0.0.1"),
        ({"interface": "lo"}, "--interface lo"),
        ({"host": "127.0.0.1"}, "--host 127.0.0.1"),
    ],
)
def test_workers_of_jobs_listen_where_the_scheduler_is_reached(tmp_path, kind, place, expected):
    """As the shell of the job writes it; not on all interfaces of its machine."""
    file = Queue(kind=kind, maximum_workers=1, walltime_minutes=60, memory_gb=4, **place)
    options = jobs.job_options(file, tmp_path, Security())
    options.pop("security")
    job = jobs.SYSTEMS[kind].job_cls("tls://127.0.0.1:1", name="one", security=None, **options)
    (command,) = (line for line in job.job_script().splitlines() if "dask_worker" in line)
    written = subprocess.run(
        ["sh", "-c", f"echo {command}"],
        cwd=Path(__file__).parents[3],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert written.rstrip().endswith(expected)
