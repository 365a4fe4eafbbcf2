"""A disk that is full in the middle of a run: told in a line, nothing lost, resumed when there is space."""

import subprocess

import pytest

from sweep.storage import records
from tests.sweep import driver
from tests.sweep.small import STUDY, invoke


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    monkeypatch.setattr("sweep.hooks.VERIFY", "none")
    return tmp_path


def check_stopped(process, directory, reason):
    """Check that a run stopped with one clear message; return the records that it left."""
    code, errors = driver.ended(process)
    assert code == 1
    assert reason in errors
    assert "what was stored before is whole; make space, and continue with: railvib resume" in errors
    assert "Traceback" not in errors
    assert list(records.failures(directory)) == []
    assert "damaged   0" in invoke("status", "--verify", directory).output
    return {record["unit_id"]: record for record in records.commits(directory)}


def check_resumed(directory, before, computed):
    """Check that a run goes on from what it had, to what it would have had at once."""
    result = invoke("resume", directory, "--workers", 0)
    assert result.exit_code == 0, result.output
    after = {record["unit_id"]: record for record in records.commits(directory)}
    assert before.items() <= after.items()
    undisturbed = {record["unit_id"]: record["arrays"] for record in records.commits(computed / "out")}
    assert {unit: record["arrays"] for unit, record in after.items()} == undisturbed


def test_a_limit_on_the_size_of_files(folder, computed):
    tables = records.commits(computed / "out", "transfer")
    record = max(tables, key=lambda each: each["costs"][-1]["bytes_written"])
    rows, nodes = record["arrays"]["wavenumber"]["shape"]
    limit = 16 * rows * nodes - 1  # the largest of the transfer functions is too large by a byte
    process = driver.start(
        folder,
        "run",
        "small.toml",
        "--workers",
        0,
        before=f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))",
    )
    directory = folder / "runs" / "small"
    before = check_stopped(process, directory, "File too large")
    assert record["unit_id"] not in before
    check_resumed(directory, before, computed)


@pytest.mark.privileged
def test_a_full_file_system(folder, computed):
    disk = folder / "disk"
    disk.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4m", "none", disk], check=True)
    try:
        unplanned = "from sweep.forecast import estimate; estimate.check = lambda *_: None"  # it would refuse
        process = driver.start(
            folder, "run", "small.toml", "--out", disk / "out", "--workers", 2, before=unplanned
        )
        before = check_stopped(process, disk / "out", "No space left on device")
        assert driver.left_behind(process.pid) == []
        assert before
        subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True)
        check_resumed(disk / "out", before, computed)
    finally:
        subprocess.run(["umount", disk], check=True)
