"""What a cluster file may say, and the jobs that follow from it."""

from pathlib import Path

import pytest
from distributed.security import Security

from railvib.errors import InputError
from sweep.workers import cluster_file, jobs
from tests.sweep.small import STUDY, invoke

ROOT = Path(__file__).parents[3]
QUEUE = {"kind": "slurm", "maximum_workers": 8, "memory_gb": 4, "walltime_minutes": 90}
SSH = {"kind": "ssh", "hosts": ["one", "two"]}
LOCAL = {"kind": "local", "maximum_workers": 2}


def written(folder, **keys):
    """Write a cluster file and return its path."""
    path = folder / "cluster.toml"
    lines = [f"{key} = {str(value).lower() if value is True else repr(value)}" for key, value in keys.items()]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "kind = None: is missing; must be one of local, ssh, slurm"),
        ({"kind": "slurmm"}, "kind = 'slurmm': is unknown; must be one of local"),
        (QUEUE | {"walltime": 3}, "walltime: unknown key; did you mean walltime_minutes?"),
        (LOCAL | {"memory_gb": 3}, "memory_gb: unknown key; "),
        (
            {key: QUEUE[key] for key in ("kind", "maximum_workers", "memory_gb")},
            "walltime_minutes: is missing",
        ),
        (QUEUE | {"walltime_minutes": 0}, "walltime_minutes = 0 min: should be greater than 0"),
        (QUEUE | {"maximum_workers": 0}, "maximum_workers = 0: should be greater than or equal to 1"),
        (QUEUE | {"minimum_workers": 9}, "minimum_workers = 9: must not exceed maximum_workers = 8"),
        (QUEUE | {"workers_per_job": 9}, "workers_per_job = 9: must not exceed maximum_workers = 8"),
        (QUEUE | {"drain_minutes": 46}, "drain_minutes = 46 min: must not exceed half of walltime_minutes"),
        (QUEUE | {"memory_gb": "4 GB"}, "memory_gb = '4 GB': should be a valid number"),
        (QUEUE | {"host": "a", "interface": "b"}, "interface = 'b': either host or interface, not both"),
        (QUEUE | {"dashboard": "8787"}, "dashboard = '8787': must be HOST:PORT"),
        (QUEUE | {"kind": "htcondor", "queue": "q"}, "queue = 'q': htcondor has none; use directives"),
        (QUEUE | {"kind": "htcondor", "directives": ["x"]}, "directives = 'x': must be KEY = VALUE"),
        ({"kind": "ssh", "hosts": []}, "hosts = []: must have at least one value"),
        (SSH | {"port": 70000}, "port = 70000: should be less than or equal to 65535"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(tmp_path, keys, message):
    with pytest.raises(InputError) as refusal:
        cluster_file.load(written(tmp_path, **keys))
    assert message in str(refusal.value)
    assert str(refusal.value).startswith(f"{tmp_path}/cluster.toml: ")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "path", sorted((ROOT / "studies" / "clusters").glob("*.toml")), ids=lambda path: path.stem
)
def test_the_examples_are_right(path):
    assert cluster_file.load(path).kind in path.stem


def script(kind, **keys):
    """Return the script of a job; LSF is asked for its version otherwise."""
    file = cluster_file.MODELS[kind].model_validate(QUEUE | {"kind": kind} | keys)
    security = Security(
        require_encryption=True, tls_ca_file="/ca", tls_worker_cert="/certificate", tls_worker_key="/key"
    )
    options = jobs.job_options(file, Path("/tmp"), security)
    system = {"use_stdin": True, "lsf_units": "mb"} if kind == "lsf" else {}
    job = jobs.SYSTEMS[kind].job_cls("tls://10.0.0.1:1", "worker", **options, **system)
    return job.job_script()


@pytest.mark.parametrize(
    ("kind", "lines"),
    [
        (
            "slurm",
            ["#SBATCH -t 01:30:00", "#SBATCH -p day", "#SBATCH -A tracks", "#SBATCH --cpus-per-task=2"],
        ),
        ("pbs", ["#PBS -l walltime=01:30:00", "#PBS -q day", "#PBS -A tracks", "ncpus=2"]),
        ("moab", ["#PBS -l walltime=01:30:00", "#PBS -q day", "#PBS -A tracks"]),
        ("sge", ["#$ -l h_rt=01:30:00", "#$ -q day", "#$ -P tracks"]),
        ("lsf", ["#BSUB -W 01:30", "#BSUB -q day", '#BSUB -P "tracks"', "#BSUB -n 2"]),
        ("oar", ["walltime=01:30:00", "#OAR -q day", "#OAR --project tracks"]),
        ("htcondor", ["RequestCpus = MY.DaskWorkerCores", "+Group = tracks"]),
    ],
)
def test_a_job_says_what_the_file_says(kind, lines):
    named = {} if kind == "htcondor" else {"queue": "day", "account": "tracks"}
    directives = ["+Group = tracks"] if kind == "htcondor" else ["--one-more"]
    text = script(kind, workers_per_job=2, directives=directives, prologue=["module load python"], **named)
    for line in lines:
        assert line in text
    assert kind == "htcondor" or "--one-more" in text
    for part in (
        "module load python",
        "export RAILVIB_JOB_STARTED=$(date +%s)",
        "export NUMBA_NUM_THREADS=1",
        "distributed.cli.dask_worker tls://10.0.0.1:1",
        "--nthreads 1",
        "--nworkers 2",
        "--no-dashboard",
        "--tls-ca-file /ca --tls-cert /certificate --tls-key /key",
    ):
        assert part in text


def test_a_batch_system_that_is_not_there_exits_with_2_and_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    result = invoke("run", "small.toml", "--cluster", written(tmp_path, **QUEUE))
    assert result.exit_code == 2
    assert "kind = 'slurm': sbatch, which hands in jobs, is not on this machine" in result.output
    assert result.output.count("\n") == 1
    assert not (tmp_path / "runs").exists()
