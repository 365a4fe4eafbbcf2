"""Runs of several directories, hosts and versions in one database."""

import shutil

import pytest
from click.testing import CliRunner

from benchmarks.runs.invented import Study
from queries import cli
from queries.database import DATABASE, ResultsError, connect, ingest
from sweep.storage import records
from tests.queries.database.test_ingest import rows

LATER = "2026-03-02T08:00:00+00:00"


@pytest.fixture
def two(tmp_path):
    """Return two run directories of the same study on two kinds of host."""
    return [
        Study(tmp_path / "here").write(lines=10),
        Study(tmp_path / "there").write(
            lines=10, run_id="run-2", started=LATER, host_class="aarch64-8", speeds=(150.0, 200.0)
        ),
    ]


def asked(path, query):
    with connect(path) as connection:
        return connection.execute(query).fetchall()


def test_runs_of_several_directories_stand_beside_each_other(two, tmp_path):
    path = tmp_path / "all.duckdb"
    ingest(two, file=path)
    assert asked(path, "FROM sources ORDER BY 1")[0][:2] == (1, "here")
    assert asked(path, "SELECT sequence, run_id, source, host_class FROM runs ORDER BY 1") == [
        (1, "run-1", 1, "x86_64-2"),
        (2, "run-2", 2, "aarch64-8"),
    ]
    assert asked(path, "SELECT count(*) FROM cases") == [(4,)]
    assert asked(path, "SELECT run_id, count(*) FROM run_accuracy GROUP BY ALL ORDER BY ALL") == [
        ("run-1", 2 * 2 * 12 * 21),
        ("run-2", 4 * 2 * 12 * 21),
    ]
    # Each case as its newest run has it, once.
    assert asked(path, "SELECT DISTINCT run_id FROM levels") == [("run-2",)]
    assert asked(path, "SELECT count(*) FROM levels") == [(4 * 3 * 12 * 21,)]


def test_directories_that_come_one_by_one_give_the_rows_of_all_at_once(two, tmp_path):
    one, other = tmp_path / "one.duckdb", tmp_path / "other.duckdb"
    ingest(two, file=one)
    ingest(two[0], file=other)
    ingest(two[1], file=other)
    assert rows(one) == rows(other)
    assert not ingest(two[0], file=other).changed
    assert not ingest((), file=other).changed


def test_a_directory_that_is_gone_keeps_its_rows(two, tmp_path):
    path = tmp_path / "all.duckdb"
    ingest(two, file=path)
    before = asked(path, "FROM run_levels ORDER BY ALL")
    shutil.rmtree(two[0])
    Study(two[1]).write(lines=10, run_id="run-3", started="2026-03-03T08:00:00+00:00", speeds=(250.0,))
    assert ingest((), file=path).changed
    assert asked(path, "FROM run_levels WHERE run_id <> 'run-3' ORDER BY ALL") == before
    assert asked(path, "SELECT count(*) FROM runs") == [(3,)]


def test_a_copy_of_a_directory_brings_nothing_twice(two, tmp_path):
    shutil.copytree(two[0], tmp_path / "copy")
    path = tmp_path / "all.duckdb"
    ingest([two[0], tmp_path / "copy"], file=path)
    assert asked(path, "SELECT count(*) FROM runs") == [(1,)]
    assert asked(path, "SELECT count(*) FROM levels") == [(2 * 3 * 12 * 21,)]
    assert asked(path, "SELECT DISTINCT cpu_s FROM runtime WHERE approach = 'full'") == [(7.5,)]


def test_runtimes_of_two_kinds_of_host_are_not_compared(two, tmp_path):
    path = tmp_path / "all.duckdb"
    ingest(two, file=path)
    found = CliRunner().invoke(cli.compare, [str(path), "--run", "run-2", "--with", "run-1"])
    assert found.exit_code == 0, found.output
    (cost,) = [line for line in found.output.splitlines() if line.split()[:2] == ["full", "2"]]
    assert cost.split() == ["full", "2", "7,500", "7,500", "7.50", "7.50", "–"]


def test_two_runs_are_compared_across_files(two):
    changed = records.Run.load(two[1])
    assert changed["run_id"] == "run-2"
    ingest(two[1])
    import duckdb

    with duckdb.connect(str(two[1] / DATABASE)) as connection:
        connection.execute("UPDATE bands SET mean_square = mean_square * 4 WHERE receiver = 'rail'")
    found = CliRunner().invoke(cli.compare, [str(two[0]), "--with", str(two[1]), "--by", "approach,receiver"])
    assert found.exit_code == 0, found.output
    lines = [line.split() for line in found.output.splitlines()]
    assert ["full", "rail", "-6.0", "6.0", "-6.0", "1"] in lines
    assert ["full", "ground", "at", "8", "m", "+0.0", "0.0", "+0.0", "1"] in lines
    assert "minus level of" in found.output


def test_a_run_that_is_not_there_is_refused(two):
    found = CliRunner().invoke(cli.compare, [str(two[0]), "--with", "run-9"])
    assert found.exit_code == 2
    assert "run-9: neither a path nor a run" in found.stderr
    assert "run-1" in found.stderr


def test_several_directories_need_a_file_of_their_own(two):
    with pytest.raises(ResultsError, match="--database FILE"):
        ingest(two)


def test_what_was_planned_and_measured_is_a_row_of_the_run(study):
    study.write(lines=10)
    manifest = records.Run.load(study.directory)
    planned = {"tasks": 7, "bytes": 10**9, "peak_memory_bytes": 2 * 10**8, "cpu_s": 12.5, "pilot_s": 0.25}
    measured = {"tasks": 7, "task_starts": 8, "bytes": 9 * 10**8, "peak_memory_bytes": 10**8, "cpu_s": 11.5}
    records.Run.publish(
        study.directory, manifest | {"planned": planned, "measured": {**measured, "wall_s": 6.0}}
    )
    ingest(study.directory)
    found = asked(
        study.directory,
        "SELECT planned_tasks, planned_bytes, planned_peak_memory_bytes, planned_cpu_s, planned_pilot_s, "
        "measured_tasks, measured_task_starts, measured_bytes, measured_peak_memory_bytes, measured_cpu_s, "
        "measured_wall_s FROM runs",
    )
    assert found == [(*planned.values(), *measured.values(), 6.0)]
