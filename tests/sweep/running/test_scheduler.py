import os
import shutil
from collections import Counter

import numpy as np
import psutil
import pytest

from railvib import signals
from sweep import plan
from sweep.running import scheduler, task
from sweep.running.task import Place
from sweep.storage import group_writer, records, store
from sweep.storage.cache import Cache
from sweep.workers import dask_cluster
from tests.sweep import toy


def run(directory, wanted, crew, attempt=1):
    work_plan = plan.make(wanted, records.ids_of(directory))
    place = Place(str(directory), "run-1", toy.__name__, attempt)
    task.forget()  # as another process would
    return scheduler.run(work_plan, place, crew, lambda *_: None)


def value(directory, unit):
    record = records.find(directory, unit.stage_name, unit.id)
    return store.read(directory, record["group"], toy.Numbers, record["arrays"]).value


def starts(folder):
    return Counter(name.partition("-")[0] for name in os.listdir(folder))


@pytest.fixture
def marks(tmp_path):
    folder = tmp_path / "marks"
    folder.mkdir()
    return str(folder)


def test_results_records_and_costs(tmp_path):
    wanted = toy.total(1, 2, 5)
    tally = run(tmp_path, [wanted], scheduler.ThisProcess())
    assert (tally.done, tally.failed, tally.skipped) == (4, 0, 0)
    np.testing.assert_array_equal(value(tmp_path, wanted), [1 + 4 + 25, 4 + 9 + 36, 9 + 16 + 49])
    record = records.find(tmp_path, "square", toy.square(2).id)
    assert record["inputs"] == {"number": 2.0}
    assert record["group"].startswith(f"square/{record['unit_id']}-")
    assert record["status"] == "done"
    stages = {cost["stage"]: cost for cost in record["costs"]}
    assert {"square", "store"} <= stages.keys() <= {"square", "other", "store"}
    assert stages["square"]["evaluations"] == 3
    assert stages["store"]["bytes_written"] > 24
    assert all(cost["peak_rss_bytes"] > 2**20 for cost in stages.values())


def test_a_process_reads_what_it_has_not_computed_itself(tmp_path):
    """What it has is held in the form in which it is read."""
    for directory, runs in (("at-once", [[1, 2]]), ("in-turn", [[1], [2], [1, 2]])):
        for numbers in runs:
            wanted = toy.total(*numbers) if len(numbers) > 1 else toy.square(*numbers)
            run(tmp_path / directory, [wanted], scheduler.ThisProcess())
    costs = [
        {cost["stage"] for cost in records.find(tmp_path / directory, "total", toy.total(1, 2).id)["costs"]}
        for directory in ("at-once", "in-turn")
    ]
    assert ["load" in stages for stages in costs] == [False, True]
    sums = [
        {record["unit_id"]: record["arrays"] for record in records.commits(tmp_path / directory)}
        for directory in ("at-once", "in-turn")
    ]
    assert sums[0] == sums[1]


def test_of_a_result_that_came_second_nothing_is_held(tmp_path):
    """What counts is what the record names: another process may have computed it with other last digits."""
    unit, place = toy.square(1), Place(str(tmp_path), "run-1", toy.__name__)
    run(tmp_path, [unit], scheduler.ThisProcess())
    task.forget()
    record = records.find(tmp_path, unit.stage_name, unit.id)
    other = toy.Numbers(np.full(3, 7.0), "square of 1", (1, 2))
    written = group_writer.write(tmp_path, "square/other", other, {})
    find = Place.find
    with pytest.MonkeyPatch.context() as patch:

        def late(self, unit):
            patch.undo()  # the record that stands comes after this look
            records.withdraw(tmp_path, unit.stage_name, unit.id)
            records.commit(tmp_path, {**record, **written.group_fields()})

        patch.setattr(Place, "find", late)
        assert task.execute("square", [unit], place).computed == 0
    assert find is Place.find
    np.testing.assert_array_equal(task.Reader(place)(unit).value, other.value)


@pytest.fixture
def remembered(tmp_path, monkeypatch):
    """A unit that this process has computed, and remembers, but does not hold."""
    monkeypatch.setattr(task, "_cache", Cache(0))
    unit = toy.square(1)
    run(tmp_path, [unit], scheduler.ThisProcess())
    return unit, records.find(tmp_path, unit.stage_name, unit.id)


def read(directory, unit):
    return task.Reader(Place(str(directory), "run-1", toy.__name__))(unit).value


def test_a_record_is_read_once(tmp_path, remembered, monkeypatch):
    unit, _ = remembered
    task.forget()
    looked_for = []
    find = records.find
    monkeypatch.setattr(records, "find", lambda *key: looked_for.append(key) or find(*key))
    for _ in range(3):
        np.testing.assert_array_equal(read(tmp_path, unit), [1, 4, 9])
    assert len(looked_for) == 1


def test_a_record_that_has_been_replaced_since_gives_way_to_the_one_that_stands(tmp_path, remembered):
    unit, record = remembered
    other = group_writer.write(tmp_path, "square/other", toy.Numbers(np.full(3, 7.0), "another", (1, 2)), {})
    shutil.rmtree(tmp_path / store.STORE / record["group"])
    records.withdraw(tmp_path, unit.stage_name, unit.id)
    records.commit(tmp_path, {**record, **other.group_fields()})
    for _ in range(2):
        np.testing.assert_array_equal(read(tmp_path, unit), np.full(3, 7.0))


def test_what_is_remembered_of_a_damaged_result_is_withdrawn_with_it(tmp_path, remembered):
    unit, record = remembered
    chunk = tmp_path / store.STORE / record["group"] / "value" / "c.0"
    chunk.write_bytes(chunk.read_bytes()[::-1])
    with pytest.raises(task.WithdrawnError, match="torn or altered"):
        read(tmp_path, unit)
    assert records.find(tmp_path, unit.stage_name, unit.id) is None
    with pytest.raises(task.WithdrawnError, match="no record"):
        read(tmp_path, unit)


def test_what_is_released_goes_first(tmp_path):
    """Results are used while those who made them hold them, and cases are done one after the other."""
    order = []
    work_plan = plan.make([toy.total(2 * n, 2 * n + 1) for n in range(40)], set())
    place = Place(str(tmp_path), "run-1", toy.__name__)

    def report(task, *_):
        order.append(task.units[0].stage_name)

    scheduler.run(work_plan, place, scheduler.ThisProcess(), report)
    assert order.count("total") == 40
    assert "total" in order[: 2 * scheduler.WINDOW_PER_WORKER]


def test_asking_twice_computes_nothing(tmp_path, marks):
    wanted = [toy.total(1, 2, marks=marks), toy.total(2, 3, marks=marks)]
    run(tmp_path, wanted, scheduler.ThisProcess())
    before = starts(marks)
    tally = run(tmp_path, wanted, scheduler.ThisProcess())
    assert tally.total == 0
    assert starts(marks) == before == {"1.0": 1, "2.0": 1, "3.0": 1, "total": 2}


def test_more_is_added_to_what_is_there(tmp_path, marks):
    run(tmp_path, [toy.total(1, 2, marks=marks)], scheduler.ThisProcess())
    run(tmp_path, [toy.total(1, 2, marks=marks), toy.total(1, 2, 7, marks=marks)], scheduler.ThisProcess())
    assert starts(marks) == {"1.0": 1, "2.0": 1, "7.0": 1, "total": 2}


def test_a_task_that_finds_its_record_computes_nothing(tmp_path, marks):
    wanted = [toy.square(1, marks=marks)]
    work_plan = plan.make(wanted, set())
    place = Place(str(tmp_path), "run-1", toy.__name__)
    for _ in range(2):
        scheduler.run(work_plan, place, scheduler.ThisProcess(), lambda *_: None)
    assert starts(marks) == {"1.0": 1}


def test_a_failure_stays_alone(tmp_path):
    poisons = {"3.0": "raise"}
    wanted = [toy.total(*numbers, poisons=poisons) for numbers in [(0, 5), (3, 5), (5, 7), (3, 7)]]
    tally = run(tmp_path, wanted, scheduler.ThisProcess())
    assert (tally.failed, tally.skipped) == (1, 2)
    assert [message for _, message in tally.failures] == ["ValueError: cannot square 3.0"]
    (failure,) = records.failures(tmp_path)
    assert failure["status"] == "failed"
    assert failure["traceback"].endswith("ValueError: cannot square 3.0\n")
    assert {wanted[0].id, wanted[2].id} <= records.ids_of(tmp_path)


def test_damage_is_found_on_use_and_made_good(tmp_path):
    part = toy.square(1)
    run(tmp_path, [part], scheduler.ThisProcess())
    group = records.find(tmp_path, part.stage_name, part.id)["group"]
    chunk = tmp_path / store.STORE / group / "value" / "c.0"
    chunk.unlink()
    tally = run(tmp_path, [toy.total(1, 2)], scheduler.ThisProcess())
    assert tally.failed == 1
    assert "square" in tally.failures[0][1]
    assert run(tmp_path, [toy.total(1, 2)], scheduler.ThisProcess()).failed == 0
    np.testing.assert_array_equal(value(tmp_path, part), [1, 4, 9])


def test_workers_compute_the_same(tmp_path):
    wanted = [toy.total(number, number + 1, number + 2) for number in range(12)]
    with dask_cluster.local(2, toy.__name__) as crew:
        assert crew.size == 2
        tally = run(tmp_path / "two", wanted, crew)
    run(tmp_path / "one", wanted, scheduler.ThisProcess())
    assert (tally.failed, tally.skipped, tally.done) == (0, 0, tally.total)
    assert psutil.Process().children(recursive=True) == [] or not any(
        "dask" in " ".join(child.cmdline()) for child in psutil.Process().children(recursive=True)
    )
    sums = {
        where: {record["unit_id"]: record["arrays"] for record in records.commits(tmp_path / where)}
        for where in ("one", "two")
    }
    assert sums["one"] == sums["two"]
    workers = {record["worker"] for record in records.commits(tmp_path / "two")}
    assert len(workers) == 2


def test_a_task_that_kills_its_worker_fails_alone(tmp_path):
    wanted = [toy.total(number, number + 1, poisons={"9.0": "kill"}) for number in range(16)]
    with dask_cluster.local(2, toy.__name__) as crew:
        tally = run(tmp_path, wanted, crew)
    assert (tally.failed, tally.skipped) == (1, 3)
    assert all(error == scheduler.LOST for _, error in tally.failures)
    assert len(list(records.commits(tmp_path, "total"))) == 13
    assert {failure["kind"] for failure in records.failures(tmp_path)} == {"square"}


def test_what_an_interruption_raises_is_no_failure(tmp_path, monkeypatch):
    """Compiled code turns the KeyboardInterrupt of a signal into an error of its own."""
    unit, place = toy.square(1, poison="raise"), Place(str(tmp_path), "run-1", toy.__name__)
    monkeypatch.setattr(signals, "_received", [15])
    with pytest.raises(KeyboardInterrupt):
        task.execute("square", [unit], place)
    assert list(records.failures(tmp_path)) == []
    monkeypatch.setattr(signals, "_received", [])
    assert task.execute("square", [unit], place).status == "failed"
