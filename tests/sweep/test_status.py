import json
import os
import shutil
from pathlib import Path

import pytest

from sweep.running import lock
from sweep.storage import records, store
from sweep.workers import leftovers
from tests.sweep.running.test_lock import ended, leave
from tests.sweep.small import invoke


@pytest.fixture
def copy(computed, tmp_path, monkeypatch):
    """Return a copy of the small study's finished run, published by nobody."""
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    monkeypatch.setattr("sweep.hooks.VERIFY", "none")
    return shutil.copytree(computed / "out", tmp_path / "out")


def unfinished(directory):
    """Make a run look as one that is under way."""
    manifest = records.Run.load(directory)
    records.Run.publish(directory, manifest | {"finished": None, "exit_status": None})


def arrays(directory):
    return {record["unit_id"]: record["arrays"] for record in records.commits(directory)}


def group(directory, stage):
    """Return the folder of a group with the most units of a stage, and these units by their labels there."""
    units = {}
    for record in records.commits(directory, stage):
        units.setdefault(record["group"], {})[record["member"]] = record["unit_id"]
    name = max(units, key=lambda each: len(units[each]))
    return directory / store.STORE / name, units[name]


def chunk(folder, name):
    return next((folder / name).glob("c.*"))


def test_a_finished_run(copy):
    output = invoke("status", copy).output
    assert "state     done, exit status 0" in output
    assert "1 of 1 complete" in output
    assert "resume" not in output


def test_a_running_one(copy):
    unfinished(copy)
    lines = [json.loads(line) for line in (copy / "log.jsonl").read_text().splitlines()]
    kept = [line for line in lines if line.get("settled", 0) <= 5 and line["event"] != "finished"]
    (copy / "log.jsonl").write_text("".join(json.dumps(line) + "\n" for line in kept) + '{"torn')
    with lock.hold(copy):
        output = invoke("status", copy).output
    assert "state     running: process" in output
    assert f"tasks     5 of {kept[0]['tasks']} settled" in output
    assert "s left" in output
    assert "resume" not in output


def test_a_dead_one(copy):
    unfinished(copy)
    leave(copy, pid=ended())
    output = invoke("status", copy).output
    assert "state     dead: process" in output
    assert f"railvib resume {copy}" in output


def test_one_of_another_host(copy):
    unfinished(copy)
    leave(copy, host="elsewhere")
    assert "on elsewhere" in invoke("status", copy).output


def flip(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def test_damage_is_found_told_and_made_good(copy):
    before = arrays(copy)
    spectra, flipped_units = group(copy, "spectra")
    flip(chunk(spectra, "psd"))
    integrals, gone_units = group(copy, "line_integrals")
    assert len(gone_units) > 1
    chunk(integrals, "frequency").unlink()  # which all of them have in common
    torn = next((copy / records.RECORDS / "receptance").iterdir())
    torn.write_bytes(torn.read_bytes()[:-40])
    transfer, altered_units = group(copy, "transfer")
    flip(transfer / "zarr.json")
    damaged = {torn.stem, *flipped_units.values(), *gone_units.values(), *altered_units.values()}
    found = invoke("status", "--verify", copy)
    assert found.exit_code == 1
    assert f"damaged   {len(damaged)}" in found.output
    assert {unit for unit in before if unit in found.output} == damaged
    assert f"railvib resume {copy}" in found.output
    assert arrays(copy).keys() == before.keys() - {torn.stem}  # looking changes nothing
    resumed = invoke("resume", copy, "--workers", 0)
    assert resumed.exit_code == 0, resumed.output
    assert resumed.output.count("damaged: ") == len(damaged)
    assert arrays(copy) == before
    assert invoke("status", "--verify", copy).exit_code == 0
    assert "1 of 1 complete" in invoke("status", copy).output


def test_damage_of_one_result_is_not_that_of_others_in_its_group(copy):
    before = arrays(copy)
    folder, units = group(copy, "line_integrals")
    said = json.loads((folder / "integral" / "zarr.json").read_text())["attributes"]["members"]
    assert said.keys() == units.keys() == {"rail", "8"}
    (folder / "integral" / f"c.{list(said).index('8')}.0.0").unlink()
    found = invoke("status", "--verify", copy)
    assert "damaged   1" in found.output
    assert {unit for unit in before if unit in found.output} == {units["8"]}
    assert invoke("resume", copy, "--workers", 0).exit_code == 0
    assert arrays(copy) == before
    assert invoke("status", "--verify", copy).exit_code == 0


@pytest.mark.parametrize("how", ["deleted", "torn"])
def test_the_database_is_derived(copy, monkeypatch, how):
    from queries.database import ingest

    ingest(copy)
    monkeypatch.setattr("sweep.hooks.VERIFY", "railvib.verify")
    database = copy / "results.duckdb"
    assert invoke("status", "--verify", copy).exit_code == 0
    if how == "deleted":
        database.unlink()
    else:
        content = bytearray(database.read_bytes())
        for place in range(len(content) // 4, len(content), 4096):  # whatever is stored there
            content[place] ^= 255
        database.write_bytes(content)
    found = invoke("status", "--verify", copy)
    assert found.exit_code == 1
    assert "results.duckdb" in found.output
    assert invoke("resume", copy, "--workers", 0).exit_code == 0
    ingest(copy)
    assert invoke("status", "--verify", copy).exit_code == 0


def write_everywhere(text):
    """Return a way to replace all manifests by a text, or to remove them."""

    def damage(copy):
        for path in (copy / "run.json", *(copy / records.RECORDS / "runs").iterdir()):
            path.unlink()
            if text is not None:
                path.write_text(text, encoding="utf-8")

    return damage


@pytest.mark.parametrize("text", [None, '{"run_id": "x", "st', "[1, 2]", "null", "{}", "[" * 100_000])
def test_a_run_without_its_manifests_goes_on_with_its_study(copy, computed, text):
    before = arrays(copy)
    write_everywhere(text)(copy)
    for command in ("status", "resume"):
        refused = invoke(command, copy)
        assert refused.exit_code == 2
        assert refused.stderr == (
            f"Error: {copy}: its manifests are gone or damaged; "
            f"go on with: railvib resume {copy} --study FILE\n"
        )
    resumed = invoke("resume", copy, "--study", computed / "small.toml", "--workers", 0)
    assert resumed.exit_code == 0, resumed.output
    assert "0 tasks to run" in resumed.output
    assert arrays(copy) == before
    assert "1 of 1 complete" in invoke("status", copy).output


def test_another_study_is_refused(copy, computed, tmp_path):
    other = tmp_path / "other.toml"
    other.write_text((computed / "small.toml").read_text().replace('"small"', '"other"'), encoding="utf-8")
    refused = invoke("resume", copy, "--study", other)
    assert refused.exit_code == 2
    assert "is 'other'; the run is of 'small'" in refused.stderr
    nothing = invoke("resume", tmp_path, "--study", other)
    assert nothing.exit_code == 2
    assert "holds no run" in nothing.stderr


def link_to_itself(path):
    path.symlink_to(path)


@pytest.mark.parametrize(
    "replace",
    [
        lambda path: path.write_text("[1]"),
        lambda path: path.write_text("null"),
        lambda path: path.write_text("[" * 100_000),
        lambda path: path.write_text('{"schema": 2}'),
        Path.mkdir,
        os.mkfifo,
        link_to_itself,
    ],
    ids=["list", "null", "nested", "without keys", "folder", "fifo", "link to itself"],
)
def test_a_record_that_is_none_is_damage(copy, replace):
    record = sorted((copy / records.RECORDS / "spectra").iterdir())[0]
    record.unlink()
    replace(record)
    assert record.stem in invoke("status", "--verify", copy).output
    resumed = invoke("resume", copy, "--workers", 0)
    assert resumed.exit_code == 0, resumed.output
    assert f"{record.stem}: its record cannot be read; it is computed again" in resumed.output
    assert invoke("status", "--verify", copy).exit_code == 0


def test_garbage_in_logs_failures_and_locks_is_passed_over(copy):
    failed = copy / records.RECORDS / "failed"
    failed.mkdir(exist_ok=True)
    (failed / "abc.json").write_text('{"unit_id": "abc"}')
    (failed / "abd.json").write_text("[1]")
    with (copy / "log.jsonl").open("a") as log:
        log.write('[1, 2]\nnull\n"x"\n{"event"\n' + "[" * 100_000 + "\n")
    (copy / "run.lock").write_bytes(b"\xff\x00garbage[1")
    for command in (("status",), ("status", "--verify"), ("resume", "--workers", 0)):
        result = invoke(command[0], copy, *command[1:])
        assert result.exit_code == 0, result.output


@pytest.mark.parametrize("command", [("status",), ("resume", "--workers", 0)])
def test_the_key_of_a_run_that_was_killed_is_removed(copy, command):
    unfinished(copy)
    leave(copy, process=ended())
    folder = copy / leftovers.FOLDER
    folder.mkdir()
    for name in (leftovers.CERTIFICATE, leftovers.KEY, "job.log"):
        (folder / name).write_text("secret")
    invoke(command[0], copy, *command[1:])
    assert [path.name for path in folder.iterdir()] == ["job.log"]


def test_the_key_of_a_run_that_is_under_way_stays(copy):
    unfinished(copy)
    key = copy / leftovers.FOLDER / leftovers.KEY
    key.parent.mkdir()
    key.write_text("secret")
    with lock.hold(copy):
        assert "running" in invoke("status", copy).output
    assert key.exists()
