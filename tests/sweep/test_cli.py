"""The commands as a user calls them, on small studies of the real physics."""

import contextlib
import json
import os
import signal
import time
from types import SimpleNamespace

import pytest

from railvib import library
from sweep.running import lock
from sweep.storage import records, store
from tests.sweep import driver
from tests.sweep.small import STUDY, invoke


def changed(study_folder, *replacements):
    text = STUDY
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    (study_folder / "small.toml").write_text(text, encoding="utf-8")


def test_a_run_leaves_manifest_records_store_and_log(computed):
    manifest = records.Run.load(computed / "out")
    assert manifest["exit_status"] == 0
    assert manifest["study_name"] == "small"
    (case,) = manifest["cases"]
    assert case["units"].keys() == {"moving-roughness", "full"}
    needed = {unit["unit_id"]: unit["scope"] for units in case["units"].values() for unit in units}
    assert needed.keys() == records.ids_of(computed / "out")
    scopes = {record["kind"]: set() for record in records.commits(computed / "out")}
    for record in records.commits(computed / "out"):
        scopes[record["kind"]].add(needed[record["unit_id"]])
        assert record["run_id"] == manifest["run_id"]
    assert scopes == {
        "transfer": {"ground"},
        "receptance": {"ground", "speed"},
        "moving_transfer": {"speed"},
        "line_integrals": {"ground"},
        "quasi_static": {"speed"},
        "spectra": {"case"},
    }
    lines = [json.loads(line) for line in (computed / "out" / "log.jsonl").read_text().splitlines()]
    assert [line["event"] for line in lines][:: len(lines) - 1] == ["planned", "finished"]
    assert {line["run_id"] for line in lines} == {manifest["run_id"]}
    assert [line["cases"] for line in lines if line.get("task", "").startswith("spectra")] == [
        [case["case_id"]]
    ] * 2
    assert len(manifest["unevenness_bands"]["german-low"]) > 1
    names = ("soil", "track", "train", "unevenness", "speed_kmh")
    assert case["labels"] == [{name: case[name] for name in names}]
    axles = manifest["axles"][case["train"]]
    assert [axle["receiver"] for axle in axles[:2]] == ["axle-1", "axle-2"]
    assert [axle["vehicle"] for axle in axles] == [1 + place // 4 for place in range(len(axles))]
    behind = [axle["behind_first_axle_m"] for axle in axles]
    assert behind == sorted(behind)
    assert behind[:2] == pytest.approx([0.0, library.load("vehicle", "regina").axle_spacing])


def test_spectra_can_be_read(computed):
    for record in records.commits(computed / "out", "spectra"):
        arrays, attributes = store.read_result(computed / "out", record)
        assert arrays["mean_square"].shape == (len(attributes["receiver"]), arrays["band"].size)
        assert arrays["mean_square"].min() > 0.0
        assert attributes["receiver"][-1] == "ground"


def test_asking_twice_computes_nothing(computed):
    before = {path: path.stat().st_mtime_ns for path in (computed / "out").rglob("*.json")}
    result = invoke("run", computed / "small.toml", "--out", computed / "out")
    assert result.exit_code == 0
    assert "0 tasks to run" in result.output
    assert {path: path.stat().st_mtime_ns for path in (computed / "out").rglob("*.json")} == before


def test_status_and_plan_of_a_finished_run(computed):
    status = invoke("status", computed / "out").output
    assert "1 of 1 complete" in status
    assert "exit status 0" in status
    plan = invoke("plan", computed / "small.toml", "--out", computed / "out").output
    assert "none: everything is there" in plan


def test_plan_writes_nothing(study_folder):
    result = invoke("plan", "small.toml")
    assert result.exit_code == 0
    assert "cases       1 (1 soil x 1 track" in result.output
    assert "2 spectra" in result.output
    assert "to write" in result.output
    assert os.listdir(study_folder) == ["small.toml"]


def test_plan_counts_what_differs_and_says_what_is_implausible(study_folder):
    changed(study_folder, ("speed_kmh = [30]", "speed_kmh = [30, 30.0, 30]"))
    result = invoke("plan", "small.toml")
    assert "cases       1 (1 soil x 1 track x 1 train x 1 unevenness spectrum x 1 speed)" in result.output
    assert "warning: german-low: 4 of 4 bands (4 to 8 Hz) rest on unevenness" in result.output


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("speed_kmh = [30]", "speed_kmh = [0]", "sweep.speed_kmh[0] = 0 km/h"),
        ("speed_kmh = [30]", "speed_kmh = [nan]", "sweep.speed_kmh[0] = nan km/h"),
        ('soil = ["horstwalde"]', 'soil = ["horstwald"]', "nearest known is 'horstwalde'"),
        ('soil = ["horstwalde"]', "soil = []", "sweep.soil = []"),
        ("minimum_hz = 4.0", "minimum_hz = 9.0", "must be below maximum_hz"),
        ("offsets_m = [8]", "offsets_m = [-8]", "receivers.offsets_m[0] = -8 m"),
        ("offsets_m", "ofsets_m", "did you mean offsets_m?"),
        ("[accuracy]", "[accuracy", "not valid TOML"),
    ],
)
@pytest.mark.parametrize("command", ["run", "plan"])
def test_a_wrong_request_exits_with_2_and_writes_nothing(study_folder, command, old, new, message):
    changed(study_folder, (old, new))
    result = invoke(command, "small.toml")
    assert result.exit_code == 2
    assert message in result.output
    assert result.output.count("\n") == 1
    assert os.listdir(study_folder) == ["small.toml"]


def test_the_directory_of_another_study_is_refused(study_folder, computed):
    changed(study_folder, ('name = "small"', 'name = "other"'))
    before = sorted((computed / "out").iterdir())
    result = invoke("run", "small.toml", "--out", computed / "out")
    assert result.exit_code == 2
    assert "is of the study 'small'" in result.output
    assert sorted((computed / "out").iterdir()) == before


def test_a_directory_of_something_else_is_refused(study_folder):
    result = invoke("run", "small.toml", "--out", ".")
    assert result.exit_code == 2
    assert "holds something else" in result.output
    assert os.listdir(study_folder) == ["small.toml"]


def test_another_speed_leaves_the_ground_alone(study_folder, computed):
    changed(study_folder, ("speed_kmh = [30]", "speed_kmh = [30, 33]"))
    result = invoke("plan", "small.toml", "--out", computed / "out")
    (line,) = [line for line in result.output.splitlines() if line.startswith("tasks")]
    assert "line_integrals" not in line
    assert "2 spectra" in line


def test_a_failed_task_is_told_and_resumed(study_folder, monkeypatch):
    from railvib.psd import line_integrals

    monkeypatch.setattr(line_integrals, "line_integrals", lambda *_: 1 / 0)
    result = invoke("run", "small.toml", "--workers", 0)
    assert result.exit_code == 1
    assert "ZeroDivisionError: division by zero" in result.output
    status = invoke("status", "runs/small")
    assert status.exit_code == 0
    assert "0 of 1 complete" in status.output
    assert "ZeroDivisionError" in status.output
    assert (
        len(list(records.commits(study_folder / "runs" / "small", "spectra"))) == 1
    )  # the full model needs none
    monkeypatch.undo()
    monkeypatch.chdir(study_folder)
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    assert invoke("resume", "runs/small", "--failed", "--workers", 0).exit_code == 0
    assert "1 of 1 complete" in invoke("status", "runs/small").output
    assert list(records.failures(study_folder / "runs" / "small")) == []


def test_damage_is_repaired_within_a_run(study_folder):
    assert invoke("run", "small.toml", "--workers", 0).exit_code == 0
    out = study_folder / "runs" / "small"
    first = next(records.commits(out, "transfer"))
    name = next(name for name in ("rail", "ground") if name in first["arrays"])
    (out / store.STORE / first["group"] / name / "c.0.0").unlink()
    for record in records.commits(out, "spectra"):
        records.withdraw(out, "spectra", record["unit_id"])
    for stage in ("line_integrals", "quasi_static", "moving_transfer", "receptance"):
        for record in records.commits(out, stage):
            records.withdraw(out, stage, record["unit_id"])
    from sweep.running import task

    task.forget()
    result = invoke("run", "small.toml", "--workers", 0)  # which, unlike resume, looks at what it uses only
    assert result.exit_code == 0, result.output
    again = records.find(out, "transfer", first["unit_id"])
    assert again["arrays"] == first["arrays"]


def test_no_run_to_resume(study_folder):
    for command in ("status", "resume"):
        result = invoke(command, "nowhere")
        assert result.exit_code == 2
        assert "holds no run" in result.output


@pytest.mark.slow
def test_ctrl_c_stops_cleanly(study_folder):
    changed(
        study_folder,
        ('soil = ["horstwalde"]', 'soil = ["horstwalde", "greby"]'),
        ("[8]", "[8, 32, 100]"),
        ("8.0", "80.0"),
    )
    process = driver.start(study_folder, "run", "small.toml", "--workers", 2)
    deadline = time.monotonic() + 60.0
    while not list((study_folder / "runs").rglob("records/transfer/*.json")) and time.monotonic() < deadline:
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)  # what a terminal does: to every process of the group
    code, errors = driver.ended(process)
    assert code == 130
    assert "railvib resume runs/small" in errors
    assert "Traceback" not in errors
    assert driver.left_behind(process.pid) == []
    assert records.Run.load(study_folder / "runs" / "small")["exit_status"] == 130
    assert "interrupted, exit status 130" in invoke("status", "runs/small").output
    assert len(records.ids_of(study_folder / "runs" / "small")) > 0
    assert not (study_folder / "runs" / "small" / lock.LOCK).exists()


def test_who_publishes_is_told_when_the_last_task_begins(study_folder, monkeypatch):
    said = []

    class Publisher(contextlib.AbstractContextManager):
        def __init__(self, directory):
            self.log = directory / "log.jsonl"

        def said(self, what):
            events = [json.loads(line)["event"] for line in self.log.read_text().splitlines()]
            said.append((what, events.count("done"), events[-1]))

        def get_ready(self):
            self.said("ready")

        def publish(self):
            self.said("publish")

        def __exit__(self, *_):
            self.said("exit")

    hook = SimpleNamespace(load=lambda: Publisher)
    monkeypatch.setattr("sweep.hooks.metadata", SimpleNamespace(entry_points=lambda group: [hook]))
    assert invoke("run", "small.toml", "--workers", 0).exit_code == 0
    tasks = said[-1][1]
    # The last but one has ended, and is about to be logged.
    assert said == [("ready", tasks - 2, "done"), ("publish", tasks, "finished"), ("exit", tasks, "finished")]
    said.clear()
    assert invoke("run", "small.toml", "--workers", 0).exit_code == 0
    assert [what for what, *_ in said] == ["publish", "exit"]
