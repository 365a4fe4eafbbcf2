import json
import multiprocessing
import os

import pytest

from sweep.storage import records
from sweep.storage.records import Run


def record(unit_id, **more):
    written = {"group": f"square/{unit_id}", "arrays": {}, "inputs": {}, "costs": [], "status": "done"}
    return {"schema": records.SCHEMA, "kind": "square", "unit_id": unit_id, **written, **more}


def manifest(run_id, started, **more):
    named = {"run_id": run_id, "study_name": "small", "study": {}, "cases": [], "host": "here"}
    return {**named, "started": f"{started}T00:00:00+00:00", "finished": None, "exit_status": 0, **more}


def test_the_first_record_stays(tmp_path):
    assert records.commit(tmp_path, record("a", worker="first"))
    assert not records.commit(tmp_path, record("a", worker="second"))
    assert records.find(tmp_path, "square", "a")["worker"] == "first"


def _commit(directory, worker, start, won):
    start.wait()
    if records.commit(directory, record("a", worker=worker)):
        won.put(worker)


def test_one_of_many_processes_is_first(tmp_path):
    context = multiprocessing.get_context("spawn")
    start, won = context.Barrier(4), context.Queue()
    processes = [context.Process(target=_commit, args=(tmp_path, worker, start, won)) for worker in range(4)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0] * 4
    assert won.get(timeout=5) == records.find(tmp_path, "square", "a")["worker"]
    assert won.empty()


def test_many_are_written_where_there_are_none_that_can_be_read(tmp_path):
    records.commit_many(tmp_path, [record(name, worker="first") for name in "ab"])
    path = tmp_path / "records" / "square" / "b.json"
    path.write_text(path.read_text().replace("first", "other"))
    made = [record(name, worker="second") for name in "abc"]
    assert records.commit_many(tmp_path, made) == [False, True, True]
    assert [record["worker"] for record in records.commits(tmp_path)] == ["first", "second", "second"]


def test_nothing_is_left_aside(tmp_path):
    records.commit(tmp_path, record("a"))
    records.commit(tmp_path, record("a"))
    assert os.listdir(tmp_path / "records" / "square") == ["a.json"]


def test_records_are_read_by_stage(tmp_path):
    for stage, unit_id in [("total", "c"), ("square", "b"), ("square", "a")]:
        records.commit(tmp_path, record(unit_id, kind=stage))
    assert [record["unit_id"] for record in records.commits(tmp_path)] == ["a", "b", "c"]
    assert [record["unit_id"] for record in records.commits(tmp_path, "square")] == ["a", "b"]
    assert records.ids_of(tmp_path) == {"a", "b", "c"}


def test_an_empty_directory_has_none(tmp_path):
    assert list(records.commits(tmp_path)) == []
    assert list(records.commits(tmp_path, "square")) == []
    assert list(records.failures(tmp_path)) == []
    assert records.runs(tmp_path) == []
    assert records.ids_of(tmp_path) == set()


def test_a_success_withdraws_the_failure(tmp_path):
    records.fail(tmp_path, record("a", status="failed", traceback="…"))
    assert [record["unit_id"] for record in records.failures(tmp_path)] == ["a"]
    records.commit(tmp_path, record("a"))
    assert list(records.failures(tmp_path)) == []


def test_a_late_failure_does_not_hide_a_success(tmp_path):
    records.commit(tmp_path, record("a"))
    records.fail(tmp_path, record("a", status="failed", traceback="…"))
    assert list(records.failures(tmp_path)) == []


def test_a_torn_record_is_none(tmp_path):
    records.commit(tmp_path, record("a"))
    path = tmp_path / "records" / "square" / "a.json"
    path.write_bytes(path.read_bytes()[:-5])
    assert records.find(tmp_path, "square", "a") is None
    assert list(records.commits(tmp_path)) == []


def test_an_altered_record_is_none_and_the_next_one_stands(tmp_path):
    records.commit(tmp_path, record("a", worker="first"))
    path = tmp_path / "records" / "square" / "a.json"
    whole = path.read_bytes()
    for place in range(len(whole)):
        altered = bytearray(whole)
        altered[place] ^= 1
        path.write_bytes(altered)
        found = records.find(tmp_path, "square", "a")
        assert found is None or found == record("a", worker="first"), bytes(altered)
    path.write_bytes(whole[:20])
    assert records.commit(tmp_path, record("a", worker="second"))
    assert records.find(tmp_path, "square", "a")["worker"] == "second"
    assert os.listdir(path.parent) == ["a.json"]


def test_a_damaged_manifest_has_a_copy(tmp_path):
    Run.publish(tmp_path, manifest("x", "2026-01-02"))
    (tmp_path / "run.json").write_text('{"run_id"')
    assert Run.load(tmp_path)["exit_status"] == 0


def test_a_withdrawn_record_can_be_written_again(tmp_path):
    records.commit(tmp_path, record("a"))
    records.withdraw(tmp_path, "square", "a")
    records.withdraw(tmp_path, "square", "a")
    assert records.commit(tmp_path, record("a"))


def test_the_latest_manifest_and_all_of_them(tmp_path):
    for run_id, started in [("y", "2026-01-01"), ("x", "2026-01-02")]:
        Run.publish(tmp_path, manifest(run_id, started, exit_status=None))
    Run.publish(tmp_path, manifest("x", "2026-01-02"))
    assert Run.load(tmp_path) == manifest("x", "2026-01-02")
    assert [manifest["run_id"] for manifest in records.runs(tmp_path)] == ["y", "x"]


def test_a_record_holds_no_nan(tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        records.commit(tmp_path, record("a", value=float("nan")))


def test_a_record_is_one_line_of_json(tmp_path):
    records.commit(tmp_path, record("a", label="Gröna Tåget"))
    text = (tmp_path / "records" / "square" / "a.json").read_text(encoding="utf-8")
    assert text.endswith("\n")
    assert json.loads(text)["label"] == "Gröna Tåget"
