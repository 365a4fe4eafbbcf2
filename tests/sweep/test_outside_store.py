"""Transfer functions outside the run: shared by studies, on a file system and on S3 over the wire."""

import os
import subprocess
import sys

import numpy as np
import pytest
import xarray
from obstore.store import S3Store
from zarr.storage import ObjectStore

import sweep
from queries.database import connect, ingest
from sweep import plan
from sweep.running import scheduler, task
from sweep.running.task import Place
from sweep.storage import checksums, group_writer, location, records, store
from tests.sweep import toy
from tests.sweep.s3_server import SECRET, s3
from tests.sweep.small import STUDY, invoke

__all__ = ["s3"]

SHARED = {"transfer", "receptance", "moving_transfer", "quasi_static", "line_integrals"}


def stages_at(home):
    """Return the stages whose results are committed at one place."""
    place = location.at(home)
    return {name for name in place.names(records.RECORDS) if place.names(f"{records.RECORDS}/{name}")}


def arrays(directory):
    """Return the checksums of all arrays that a run rests on, by unit."""
    return {record["unit_id"]: record["arrays"] for record in records.commits(directory)}


def test_on_s3_a_run_is_broken_off_resumed_shared_and_read(study_folder, s3, computed, monkeypatch):
    from railvib.psd import full_model_spectra, moving_roughness_spectra

    address = f"{s3}/studies"
    with monkeypatch.context() as broken:
        broken.setattr(moving_roughness_spectra, "moving_roughness_spectra", lambda *_: 1 / 0)
        broken.setattr(full_model_spectra, "full_model_spectra", lambda *_: 1 / 0)
        assert invoke("run", "small.toml", "--workers", 0, "--store", address).exit_code == 1
    out = study_folder / "runs" / "small"
    assert stages_at(address) == SHARED
    assert not (out / store.STORE).exists()
    written = {key: location.at(address).read(key) for key in keys(address)}

    resumed = invoke("resume", out, "--workers", 0)  # the manifest knows the store
    assert resumed.exit_code == 0, resumed.output
    assert "2 tasks to run" in resumed.output
    assert stages_at(out) == {"runs", "spectra"}
    assert {key: location.at(address).read(key) for key in keys(address)} == written
    assert arrays(out) == arrays(computed / "out")
    assert "1 of 1 complete" in invoke("status", out).output
    assert "everything is there" in invoke("plan", "small.toml").output

    record = next(records.commits(out, "transfer"))
    group = f"studies/{store.STORE}/{record['group']}"
    with xarray.open_zarr(ObjectStore(S3Store("vibration", prefix=group), read_only=True)) as dataset:
        assert dataset.wavenumber.dims == ("frequency", "node")
        assert checksums.checksum(dataset.wavenumber.values) == record["arrays"]["wavenumber"]
    xarray.testing.assert_equal(sweep.open_grid(out).compute(), sweep.open_grid(computed / "out").compute())

    text = STUDY.replace('"small"', '"other"').replace("german-low", "german-high")
    (study_folder / "other.toml").write_text(text, encoding="utf-8")
    planned = invoke("plan", "other.toml", "--store", address).output
    assert "tasks       2 (2 spectra)" in planned

    ingest(out)
    with connect(out) as connection:
        assert connection.execute(
            "SELECT count(*) > 0, count(*) = count(error_db) FROM accuracy"
        ).fetchall() == [(True, True)]
        assert connection.execute("SELECT count(*) FROM receptances").fetchone()[0] > 0
        stages = {kind for (kind,) in connection.execute("SELECT DISTINCT kind FROM unit_costs").fetchall()}
    assert stages == {*SHARED, "spectra"}
    said = "".join(path.read_text() for path in out.rglob("*.json*"))
    assert SECRET not in said
    assert address in said


def keys(address):
    return [
        f"{records.RECORDS}/{stage}/{name}"
        for stage in stages_at(address)
        for name in location.at(address).names(f"{records.RECORDS}/{stage}")
    ]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("s3://no-such-bucket/x", "there is no such bucket"),
        ("http://bucket/x", "must be a path or s3://BUCKET/PREFIX"),
        ("small.toml/store", "is no folder that can be written to"),
    ],
)
@pytest.mark.parametrize("command", ["run", "plan"])
def test_a_store_that_cannot_be_used_exits_with_2_and_writes_nothing(
    study_folder, s3, command, given, message
):
    result = invoke(command, "small.toml", "--store", given)
    assert result.exit_code == 2
    assert message in result.output
    assert result.output.count("\n") == 1
    assert os.listdir(study_folder) == ["small.toml"]


@pytest.fixture(params=["folder", "bucket"])
def outside(request, tmp_path):
    if request.param == "folder":
        return str(tmp_path / "shared")
    return f"{request.getfixturevalue('s3')}/{tmp_path.name}"


def run(directory, wanted, outside):
    work_plan = plan.make(wanted, records.ids_at(directory) | records.ids_at(outside))
    place = Place(str(directory), "run-1", toy.__name__, store=outside)
    task.forget()  # as another process would
    return scheduler.run(work_plan, place, scheduler.ThisProcess(), lambda *_: None)


def test_shared_units_go_outside_and_are_used_again(tmp_path, outside):
    assert run(tmp_path / "a", [toy.total(1, 2)], outside).total == 3
    assert run(tmp_path / "b", [toy.total(1, 2)], outside).total == 1
    assert run(tmp_path / "b", [toy.total(1, 2, 9)], outside).total == 2
    assert stages_at(outside) == {"square"}
    assert stages_at(tmp_path / "b") == {"total"}


@pytest.mark.parametrize("harm", ["flip", "delete", "record"])
def test_damage_outside_is_found_on_use_and_made_good(tmp_path, outside, harm):
    run(tmp_path, [toy.square(1)], outside)
    place, unit = location.at(outside), toy.square(1)
    record = records.find(outside, unit.stage_name, unit.id)
    key = f"{store.STORE}/{record['group']}/value/c.0"
    if harm == "record":
        key = f"{records.RECORDS}/square/{unit.id}.json"
    content = bytearray(place.read(key))
    place.remove(key)
    if harm != "delete":
        content[10] ^= 1
        place.create(key, bytes(content))
    assert run(tmp_path, [toy.total(1, 2)], outside).damaged == 1
    assert run(tmp_path, [toy.total(1, 2)], outside).failed == 0
    again = records.find(outside, unit.stage_name, unit.id)
    assert again["arrays"] == record["arrays"]
    np.testing.assert_array_equal(
        store.read(outside, again["group"], toy.Numbers, again["arrays"], again["metadata"]).value, [1, 4, 9]
    )


def test_of_two_results_that_differ_one_counts_and_neither_is_torn(tmp_path, outside):
    results = [toy.Numbers(np.arange(3.0) + 1e-16 * place, "", ()) for place in (0, 2)]
    written = [group_writer.write(outside, "square/x", result, {}) for result in results]
    won = [
        records.commit(
            outside,
            {
                "schema": records.SCHEMA,
                "kind": "square",
                "unit_id": "x",
                "group": stored.group,
                "arrays": stored.arrays,
                "inputs": {},
                "costs": [],
            },
        )
        for stored in reversed(written)
    ]
    assert won == [True, False]
    record = records.find(outside, "square", "x")
    value = store.read(outside, record["group"], toy.Numbers, record["arrays"]).value
    np.testing.assert_array_equal(value, results[1].value)


@pytest.mark.slow
def test_two_drivers_at_once_share_a_store(study_folder, computed, outside):
    other = STUDY.replace('"small"', '"other"').replace("german-low", "german-high")
    (study_folder / "other.toml").write_text(other, encoding="utf-8")
    code = "from railvib.cli import main; main()"
    drivers = [
        subprocess.Popen(
            [sys.executable, "-c", code, "run", f"{name}.toml", "--workers", "1", "--store", outside],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
        )
        for name in ("small", "other")
    ]
    said = [driver.communicate(timeout=300)[1] for driver in drivers]
    assert [driver.returncode for driver in drivers] == [0, 0], said
    small, other = study_folder / "runs" / "small", study_folder / "runs" / "other"
    manifests = [records.Run.load(directory) for directory in (small, other)]
    assert max(manifest["started"] for manifest in manifests) < min(
        manifest["finished"] for manifest in manifests
    )
    assert [manifest["store"] for manifest in manifests] == [outside, outside]
    assert arrays(small) == arrays(computed / "out")
    both = {**arrays(small), **arrays(other)}
    assert len(both) == len(arrays(small)) + 2  # but for the other study's spectra all is shared
    for directory in (small, other):
        assert stages_at(directory) - {"failed", "runs"} == {"spectra"}
        for record in records.commits(directory):
            store.check(directory, record)
    by_run = {record["run_id"] for record in records.commits(small) if record["kind"] in SHARED}
    assert by_run <= {manifest["run_id"] for manifest in manifests}
    groups = [record["group"] for record in records.commits(small) if record["kind"] in SHARED]
    there = sum(len(location.at(outside).names(f"{store.STORE}/{stage}")) for stage in SHARED)
    # The same bytes whoever computed them: at most one group each, beside the zarr.json of its stage.
    assert len(set(groups)) <= there - len(SHARED) <= len(groups)
