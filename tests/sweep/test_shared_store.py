"""Two drivers at once on one store: what their studies share is there once, and whole."""

from datetime import datetime

import pytest

from sweep.storage import records
from tests.sweep import driver
from tests.sweep.small import STUDY, invoke


def units(manifest, scope):
    return {
        unit["unit_id"]
        for case in manifest["cases"]
        for item in case["units"].values()
        for unit in item
        if unit["scope"] == scope
    }


@pytest.mark.slow
def test_two_drivers_share_a_store(tmp_path, computed, monkeypatch):
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    monkeypatch.setattr("sweep.hooks.VERIFY", "none")
    shared = tmp_path / "shared"
    for name, speeds in (("one", "[30, 31]"), ("other", "[32, 30]")):
        text = STUDY.replace('"small"', f'"{name}"').replace("[30]", speeds)
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    drivers = [
        driver.start(tmp_path, "run", f"{name}.toml", "--store", shared, "--workers", 0)
        for name in ("one", "other")
    ]
    assert [driver.ended(process)[0] for process in drivers] == [0, 0]
    manifests = [records.Run.load(tmp_path / "runs" / name) for name in ("one", "other")]
    began, ended = (
        [datetime.fromisoformat(manifest[key]) for manifest in manifests] for key in ("started", "finished")
    )
    assert max(began) < min(ended)  # they did run at once
    ground = [units(manifest, "ground") for manifest in manifests]
    assert ground[0] == ground[1] <= records.ids_at(shared)
    assert {record["run_id"] for record in records.commits(shared)} == {
        manifest["run_id"] for manifest in manifests
    }
    for name in ("one", "other"):
        status = invoke("status", "--verify", tmp_path / "runs" / name)
        assert status.exit_code == 0, status.output
        assert "damaged   0" in status.output
        assert "2 of 2 complete" in status.output
        assert records.ids_at(tmp_path / "runs" / name).isdisjoint(records.ids_at(shared))
    undisturbed = {record["unit_id"]: record["arrays"] for record in records.commits(computed / "out")}
    found = {record["unit_id"]: record["arrays"] for record in records.commits(shared)}
    common = undisturbed.keys() & found.keys()
    assert ground[0] <= common
    assert {unit: found[unit] for unit in common} == {unit: undisturbed[unit] for unit in common}
    assert not list(shared.rglob("*.partial/*"))
