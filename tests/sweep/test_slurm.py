"""A real Slurm of one node: jobs through a cluster file, one of them cancelled; a run in one allocation."""

import os
import subprocess
import time
from pathlib import Path

import pytest

from sweep.storage import records
from sweep.workers import jobs
from tests.sweep.small import STUDY, invoke

ROOT = Path(__file__).parents[2]
CLUSTER = """
kind = "slurm"
minimum_workers = 2
maximum_workers = 2
memory_gb = 1
walltime_minutes = 20
prologue = ["export PYTHONPATH={root}"]
"""
LONGER = STUDY.replace("[30]", "{ start = 30, stop = 60, step = 5 }")

pytestmark = pytest.mark.privileged


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    """Start Slurm, and let this process and its children find it."""
    folder = tmp_path_factory.mktemp("slurm")
    script = ROOT / "scripts" / "one-node-slurm"
    with pytest.MonkeyPatch.context() as patch:
        started = subprocess.run(
            [script, "start", folder, "4"], stderr=subprocess.PIPE, text=True, check=False
        )
        assert started.returncode == 0, started.stderr
        patch.setenv("SLURM_CONF", str(folder / "slurm.conf"))
        patch.setenv("PYTHONPATH", str(ROOT))
        try:
            yield
        finally:
            subprocess.run([script, "stop", folder], check=True)


@pytest.fixture
def study_folder(tmp_path, monkeypatch):
    """Return a directory to work in with a study and a cluster file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(LONGER, encoding="utf-8")
    (tmp_path / "cluster.toml").write_text(CLUSTER.format(root=ROOT), encoding="utf-8")
    return tmp_path


def workers():
    """Return the ids of the jobs in which workers run."""
    command = ["squeue", "--noheader", "--format=%A", "--states=RUNNING", "--name=railvib"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def await_(condition, seconds=120.0):
    deadline = time.monotonic() + seconds
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert condition()


def assert_complete(out):
    cases = len(records.Run.load(out)["cases"])
    assert f"{cases} of {cases} complete" in invoke("status", out).output
    made = {record["worker"] for record in records.commits(out)}
    assert os.getpid() not in {int(worker.rpartition(":")[2]) for worker in made}
    return made


def test_the_driver_is_a_job_and_starts_jobs_of_which_one_is_cancelled(slurm, study_folder):
    (study_folder / ".venv" / "bin").mkdir(parents=True)
    (study_folder / ".venv" / "bin" / "railvib").symlink_to(ROOT / ".venv" / "bin" / "railvib")
    out = study_folder / "runs" / "small"
    driver = ["sbatch", "--wait", "--mem=1G", ROOT / "scripts" / "slurm-driver", "small.toml"]
    with subprocess.Popen([*driver, "--cluster", "cluster.toml"], stdout=subprocess.DEVNULL) as waiting:
        await_(lambda: len(workers()) == 2 and (out / "records" / "transfer").exists())
        first, second = workers()
        subprocess.run(["scancel", first], check=True)
        assert records.Run.load(out)["finished"] is None  # it was in the middle
        waiting.wait(timeout=300)
    (log,) = study_folder.glob("railvib-driver-*.log")
    assert waiting.returncode == 0, log.read_text()
    assert len(assert_complete(out)) >= 2
    await_(lambda: not workers())
    left = {path.name for path in (out / jobs.FOLDER).iterdir()}
    assert {f"railvib-{first}.err", f"railvib-{second}.err"} <= left
    assert not any(name.endswith(".pem") for name in left)


def test_the_ranks_of_one_allocation_are_scheduler_driver_and_workers(slurm, study_folder):
    script = ROOT / "scripts" / "slurm-allocation"
    (study_folder / "small.toml").write_text(STUDY, encoding="utf-8")
    command = ["srun", "--ntasks=4", "--kill-on-bad-exit=1", script, "small.toml", "--out", "out"]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert run.returncode == 0, run.stderr
    assert 1 <= len(assert_complete(study_folder / "out")) <= 2
    assert {path.name for path in study_folder.iterdir()} == {"cluster.toml", "out", "small.toml"}


def test_a_refused_study_ends_all_ranks_with_one_line(slurm, study_folder):
    script = ROOT / "scripts" / "slurm-allocation"
    (study_folder / "small.toml").write_text(STUDY.replace("horstwalde", "nowhere"), encoding="utf-8")
    run = subprocess.run(
        ["srun", "--ntasks=4", script, "small.toml"], capture_output=True, text=True, timeout=60, check=False
    )
    assert run.returncode == 2
    told, srun = run.stderr.splitlines()
    assert told.startswith("Error: sweep.soil = 'nowhere': is unknown")
    assert "task 1: Exited with exit code 2" in srun
    assert {path.name for path in study_folder.iterdir()} == {"cluster.toml", "small.toml"}


def test_a_cancelled_allocation_leaves_no_certificate(slurm, study_folder):
    script = ROOT / "scripts" / "slurm-allocation"
    srun = f"srun --kill-on-bad-exit=1 {script} small.toml --out out"
    subprocess.run(["sbatch", "--ntasks=4", "--output=log", "--wrap", srun], check=True)
    await_(lambda: (study_folder / "out" / "records" / "transfer").exists())
    assert [path.name for path in study_folder.glob(".railvib-*/*.pem")]
    subprocess.run(["scancel", "--user", "root"], check=True)
    await_(lambda: not list(study_folder.glob(".railvib-*")))
    await_(lambda: "continue with: railvib resume out" in (study_folder / "log").read_text())


def test_too_few_ranks_are_refused(slurm, study_folder):
    script = ROOT / "scripts" / "slurm-allocation"
    run = subprocess.run(
        ["srun", "--ntasks=2", script, "small.toml"], capture_output=True, text=True, timeout=60, check=False
    )
    assert run.returncode == 2
    assert "--ntasks = 2: must be at least 3: scheduler, driver and a worker" in run.stderr
    assert not (study_folder / "runs").exists()


def test_a_job_that_slurm_refuses_is_told(slurm, study_folder):
    (study_folder / "cluster.toml").write_text(CLUSTER.format(root=ROOT) + 'queue = "nope"', encoding="utf-8")
    result = invoke("run", "small.toml", "--cluster", "cluster.toml")
    assert result.exit_code == 2
    assert "a job is refused: sbatch: error: invalid partition specified: nope" in result.output
    assert workers() == []
