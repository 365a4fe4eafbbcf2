"""Processes killed at the worst of times: nothing is lost, counted twice, or left running."""

import json
import os
import random
import shutil
import signal
import threading
from collections import Counter

import duckdb
import psutil
import pytest

from queries.database import ingest
from railvib.parameters.units import KMH
from sweep import plan
from sweep.running import scheduler
from sweep.running.task import Place
from sweep.storage import records
from sweep.workers import dask_cluster
from tests.sweep import driver, poisoned, toy
from tests.sweep.small import STUDY, invoke

VOLATILE = {"run_id", "worker", "attempt", "started", "finished", "wall_s", "cpu_s", "peak_rss_bytes"}
"""Columns that say when, where and how fast a result was computed."""
ABOUT_RUNS = {"runs", "run_cases", "case_units", "sources", "snapshot"}
INCIDENTAL = "stage NOT IN ('load', 'other')"
"""A worker loads what it does not hold from the task before; what takes next to no time is no stage."""
KILL = "os.kill(os.getpid(), signal.SIGKILL)"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with the small study; the tests themselves make the database."""
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    return tmp_path


@pytest.fixture(scope="module")
def undisturbed(computed, tmp_path_factory):
    """Return the run directory of an undisturbed run of the small study."""
    return shutil.copytree(computed / "out", tmp_path_factory.mktemp("undisturbed") / "out")


def rows(directory):
    """Return the rows of all tables of results, as often as each is there, without times and places."""
    ingest(directory)
    with duckdb.connect(str(directory / "results.duckdb"), read_only=True) as database:
        found = {}
        for (table,) in database.execute("SELECT table_name FROM duckdb_tables()").fetchall():
            if table in ABOUT_RUNS:
                continue
            columns = [row[0] for row in database.execute(f"DESCRIBE {table}").fetchall()]
            kept = ", ".join(f'"{column}"' for column in columns if not volatile(column))
            if kept:
                which = INCIDENTAL if "stage" in columns else "true"
                query = f"SELECT {kept} FROM {table} WHERE {which}"
                found[table] = Counter(map(str, database.execute(query).fetchall()))
        return found


def volatile(column):
    return column in VOLATILE or column.startswith(("host", "source"))


def arrays(directory):
    return {record["unit_id"]: record["arrays"] for record in records.commits(directory)}


def logged(directory, run_id):
    lines = [json.loads(line) for line in (directory / "log.jsonl").read_text().splitlines()]
    return [line for line in lines if line["run_id"] == run_id]


def workers():
    """Return the worker processes: children of the one from which they are forked."""
    family = psutil.Process().children(recursive=True)
    forks = {process.pid for process in family if "forkserver" in " ".join(process.cmdline())}
    return [
        process for process in family if process.ppid() in forks and process.status() != psutil.STATUS_ZOMBIE
    ]


def run(directory, wanted, crew):
    work_plan = plan.make(wanted, records.ids_of(directory))
    settled = []
    tally = scheduler.run(
        work_plan,
        Place(str(directory), "run-1", toy.__name__),
        crew,
        lambda task, outcome, tally: settled.append(task.key),
    )
    assert sorted(settled) == sorted(work_plan.tasks)
    return tally


@pytest.mark.slow
def test_six_killed_workers_lose_nothing(tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    draw = random.Random(6)
    work = {"sleep": 0.03, "marks": str(marks)}
    wanted = [toy.total(number, number + 2, **work) for number in range(0, 400, 4)]
    killed = []

    def kill(stop):
        while len(killed) < 6 and not stop.is_set():
            stop.wait(draw.uniform(0.2, 0.6))
            running = workers()
            if running and any(marks.iterdir()) and not stop.is_set():
                victim = draw.choice(running)
                victim.kill()
                killed.append(victim.pid)

    with dask_cluster.local(2, toy.__name__) as crew:
        stop = threading.Event()
        killer = threading.Thread(target=kill, args=[stop])
        killer.start()
        tally = run(tmp_path / "killed", wanted, crew)
        stop.set()
        killer.join()
    assert len(killed) == 6
    assert (tally.total, tally.done, tally.failed, tally.skipped) == (300, 300, 0, 0)
    assert len(os.listdir(marks)) <= 330
    assert Counter(record["unit_id"] for record in records.commits(tmp_path / "killed")).total() == 300
    run(tmp_path / "undisturbed", wanted, scheduler.ThisProcess())
    assert arrays(tmp_path / "killed") == arrays(tmp_path / "undisturbed")


AT_A_THIRD = f"""
import os, signal
from sweep import progress
write = progress.Log.write
def fatal(self, event, **facts):
    write(self, event, **facts)
    if 3 * facts.get("settled", 0) >= facts["tasks"]:
        {KILL}
progress.Log.write = fatal
"""


@pytest.mark.slow
def test_a_killed_driver_leaves_no_process_and_what_is_missing(folder, undisturbed):
    process = driver.start(folder, "run", "small.toml", "--workers", 2, before=AT_A_THIRD)
    assert driver.ended(process)[0] == -signal.SIGKILL
    assert driver.left_behind(process.pid) == []
    directory = folder / "runs" / "small"
    first = records.Run.load(directory)
    assert first["exit_status"] is None
    assert "state     dead: process" in invoke("status", directory).output
    before = {record["unit_id"]: record for record in records.commits(directory)}
    tasks = logged(directory, first["run_id"])[0]["tasks"]
    assert 0 < len(before) < len(arrays(undisturbed))
    resumed = invoke("resume", directory, "--workers", 0)
    assert resumed.exit_code == 0, resumed.output
    assert f"process {process.pid} on " in resumed.output
    after = {record["unit_id"]: record for record in records.commits(directory)}
    assert {unit: record for unit, record in after.items() if record["run_id"] == first["run_id"]} == before
    second = logged(directory, records.Run.load(directory)["run_id"])
    computed = [line["task"] for line in second if line["event"] == "done"]
    assert len(computed) == len(set(computed)) == second[0]["tasks"] < tasks
    assert arrays(directory) == arrays(undisturbed)
    assert rows(directory) == rows(undisturbed)


IN_A_CHUNK = f"""
import os, signal
from sweep.storage import folder
write = folder._write
written = []
def torn(path, content):
    if "transfer_functions.zarr" in path and "/c." in path:
        written.append(path)
        if len(written) == 30:
            write(path, bytes(content)[: len(content) // 2])
            {KILL}
    return write(path, content)
folder._write = torn
"""


def test_a_driver_killed_inside_a_zarr_write(folder, undisturbed):
    process = driver.start(folder, "run", "small.toml", "--workers", 0, before=IN_A_CHUNK)
    assert driver.ended(process)[0] == -signal.SIGKILL
    directory = folder / "runs" / "small"
    assert any((directory / "transfer_functions.zarr.partial").iterdir())
    assert 0 < len(arrays(directory)) < len(arrays(undisturbed))
    assert "damaged   0" in invoke("status", "--verify", directory).output
    assert invoke("resume", directory, "--workers", 0).exit_code == 0
    assert not (directory / "transfer_functions.zarr.partial").exists()
    assert arrays(directory) == arrays(undisturbed)
    assert rows(directory) == rows(undisturbed)


IN_THE_DATABASE = f"""
import os, signal
from queries.database.rows import Writer
flush = Writer.flush
def torn(self):
    flush(self)
    {KILL}
Writer.flush = torn
"""


def test_a_driver_killed_inside_the_database_write(folder, undisturbed):
    directory = shutil.copytree(undisturbed, folder / "out")
    (directory / "results.duckdb").unlink(missing_ok=True)
    process = driver.start(folder, "resume", "out", "--workers", 0, before=IN_THE_DATABASE)
    assert driver.ended(process)[0] == -signal.SIGKILL
    assert driver.left_behind(process.pid) == []
    assert list(directory.glob("results.duckdb.*.partial"))
    assert not (directory / "results.duckdb").exists()
    assert invoke("status", "--verify", directory).exit_code == 1
    assert invoke("resume", directory, "--workers", 0).exit_code == 0
    assert rows(directory) == rows(undisturbed)
    assert invoke("status", "--verify", directory).exit_code == 0


@pytest.mark.slow
def test_poisoned_cases_fail_alone_and_are_retried(folder, computed, monkeypatch):
    text = STUDY.replace('"moving-roughness", "full"', '"moving-roughness"').replace(
        'reference = "full"', 'reference = "moving-roughness"'
    )
    (folder / "small.toml").write_text(text.replace("[30]", "[30, 31, 32, 33]"), encoding="utf-8")
    directory = folder / "out"
    monkeypatch.setattr("sweep.run.STAGES", poisoned.__name__)
    monkeypatch.setenv(poisoned.POISON, '{"31": "raise", "32": "kill"}')
    result = invoke("run", folder / "small.toml", "--out", directory, "--workers", 2)
    assert result.exit_code == 1, result.output
    tracebacks = {
        record["inputs"]["speed"] * KMH: record["traceback"] for record in records.failures(directory)
    }
    assert {round(speed, 6) for speed in tracebacks} == {31.0, 32.0}
    told = "".join(tracebacks.values())
    assert "Traceback" in told
    assert "ArithmeticError: poisoned at 31 km/h" in told
    assert scheduler.LOST in told
    assert len(list(records.commits(directory, "spectra"))) == 2
    status = invoke("status", directory).output
    assert "2 of 4 complete" in status
    assert "failures  2" in status
    before = arrays(directory)
    monkeypatch.delenv(poisoned.POISON)
    resumed = invoke("resume", directory, "--failed", "--workers", 0)
    assert resumed.exit_code == 0, resumed.output
    assert "2 tasks to run" in resumed.output
    assert before.items() <= arrays(directory).items()
    assert "4 of 4 complete" in invoke("status", directory).output
