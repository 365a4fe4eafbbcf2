import json
import shutil

import pytest

from sweep.running import lock
from sweep.storage import records, store
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
