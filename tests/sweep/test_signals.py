"""Signals that end the program, whatever it is doing: one line, exit code 130, and no process left behind."""

import os
import signal
import time

import psutil
import pytest

from sweep.running import lock
from sweep.storage import records
from tests.sweep import driver
from tests.sweep.small import STUDY

pytestmark = pytest.mark.slow

LONG = STUDY.replace('["horstwalde"]', '["horstwalde", "greby"]').replace("[8]", "[8, 32, 100]")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with a study that takes some time, and let temporary files lie in it."""
    (tmp_path / "small.toml").write_text(LONG.replace("8.0", "80.0"), encoding="utf-8")
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    return tmp_path


def is_measuring(folder, process):
    return any((folder / "tmp").glob("railvib-pilot-*/records"))


def is_compiling(folder, process):
    """Whether the process that compiles has been forked: it alone has children without a program."""
    family = psutil.Process(process.pid).children(recursive=True)
    return len(family) > 2 and any((folder / "compiled").rglob("*.nbi"))


def has_results(folder, process):
    return any((folder / "runs").glob("*/records/transfer/*.json"))


MOMENTS = {
    "plan": (["plan", "small.toml"], ["XDG_CACHE_HOME"], is_measuring),
    "compile": (["run", "small.toml", "--workers", 2], ["XDG_CACHE_HOME", "NUMBA_CACHE_DIR"], is_compiling),
    "pilot": (["run", "small.toml", "--workers", 2], ["XDG_CACHE_HOME"], is_measuring),
    "pilot alone": (["run", "small.toml", "--workers", 0], ["XDG_CACHE_HOME"], is_measuring),
    "tasks": (["run", "small.toml", "--workers", 2], [], has_results),
    "tasks here": (["run", "small.toml", "--workers", 0], [], has_results),
}


def await_(condition, folder, process):
    deadline = time.monotonic() + 100.0
    while not condition(folder, process):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < deadline
        time.sleep(0.02)


def start(folder, monkeypatch, moment):
    """Start a command in a new environment, and return it at a moment."""
    arguments, caches, condition = MOMENTS[moment]
    for name in caches:
        monkeypatch.setenv(name, str(folder / "compiled"))
    process = driver.start(folder, *arguments)
    await_(condition, folder, process)
    return process


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_command_in_one_line(folder, monkeypatch, moment, number):
    process = start(folder, monkeypatch, moment)
    if number == signal.SIGTERM:
        os.kill(process.pid, number)
    else:
        os.killpg(process.pid, number)  # as terminals do: to every process of the group
    code, errors = driver.ended(process)
    assert code == 130, errors
    assert driver.left_behind(process.pid) == []
    said = [line for line in errors.splitlines() if "tasks" not in line and not line.startswith("warning")]
    assert len(said) == 1
    assert said[0].startswith("interrupted")
    out = folder / "runs" / "small"
    assert not (out / lock.LOCK).exists()
    if "tasks" in moment:
        assert said[0].endswith("continue with: railvib resume runs/small")
        assert records.Run.load(out)["exit_status"] == 130
    else:
        assert not out.exists()


IN_A_QUERY = """
import duckdb, os, signal, threading
from queries.database.rows import Writer
def slow(self):
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGTERM)).start()
    duckdb.sql("SELECT sum(hash(range)) FROM range(1000000000000)").fetchall()
Writer.flush = slow
"""


def test_a_signal_while_results_are_published(folder):
    (folder / "small.toml").write_text(STUDY, encoding="utf-8")
    process = driver.start(folder, *MOMENTS["tasks here"][0], before=IN_A_QUERY)
    code, errors = driver.ended(process)
    assert code == 130, errors
    assert errors.splitlines()[-1].startswith("interrupted; what is done is kept")
    assert "Traceback" not in errors
    assert driver.left_behind(process.pid) == []


@pytest.mark.parametrize("moment", MOMENTS)
def test_processes_end_with_a_driver_that_is_killed(folder, monkeypatch, moment):
    process = start(folder, monkeypatch, moment)
    os.kill(process.pid, signal.SIGKILL)
    assert driver.ended(process)[0] == -signal.SIGKILL
    assert driver.left_behind(process.pid) == []


def test_a_hang_up_is_ignored_by_who_was_told_so(folder, monkeypatch):
    """As nohup does."""
    process = driver.start(
        folder,
        *MOMENTS["tasks"][0],
        before="import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)",
    )
    await_(has_results, folder, process)
    os.killpg(process.pid, signal.SIGHUP)
    time.sleep(0.5)
    assert process.poll() is None
    process.terminate()
    assert driver.ended(process)[0] == 130
