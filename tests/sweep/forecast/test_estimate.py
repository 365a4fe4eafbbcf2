"""What the plan says beforehand, against what runs take; and what it refuses."""

import json
import os
import re
import subprocess
import sys
import tomllib

import pytest

from railvib.errors import InputError
from railvib.stages import Work
from railvib.stages.train_integrals import ReceiverTrainIntegrals
from sweep import study
from sweep.forecast import estimate, pilot
from sweep.processes import forks
from sweep.request import prepare
from sweep.storage import records
from sweep.unit import work
from tests.sweep.small import STUDY, invoke

GB = 10**9
LONG = """
[train.long]
vehicles = [{ vehicle = "velaro-e", number = 4 }]
"""
BOTH = 'reference = "full"\naveraging = ["line", "train"]'
STUDIES = {
    "near": [("[8]", "[0, 8]"), ("8.0", "20.0"), ("[30]", "[60, 70, 80]")],
    "far": [('"horstwalde"', '"greby"'), ("[8]", "[100]"), ('reference = "full"', BOTH)],
    "long": [('["single"]', '["long", "single"]'), ("[30]", "[100, 120]"), ("[train.s", LONG + "[train.s")],
}


def text(name):
    found = STUDY.replace('"small"', f'"{name}"')
    for old, new in STUDIES[name]:
        assert old in found
        found = found.replace(old, new)
    return found


def request(tmp_path, **sections):
    data = tomllib.loads(STUDY)
    for name, values in sections.items():
        data[name] = data.get(name, {}) | values
    return prepare(study.resolve(data), tmp_path / "out")


@pytest.fixture(scope="module")
def rates():
    ReceiverTrainIntegrals.compile()  # a plan tells what work takes, not what compiling on demand does
    return pilot.rates()


@pytest.mark.slow
@pytest.mark.parametrize("name", STUDIES)
def test_a_run_takes_what_was_planned(name, rates, tmp_path, monkeypatch):
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    (tmp_path / "study.toml").write_text(text(name), encoding="utf-8")
    result = invoke("run", tmp_path / "study.toml", "--out", tmp_path / "out", "--workers", 1)
    assert result.exit_code == 0, result.output
    manifest = records.Run.load(tmp_path / "out")
    planned, measured = manifest["planned"], manifest["measured"]
    assert measured["tasks"] == measured["task_starts"] == planned["tasks"]
    assert measured["cpu_s"] / 2.0 < planned["cpu_s"] < 2.0 * measured["cpu_s"]
    assert measured["peak_memory_bytes"] <= planned["peak_memory_bytes"]
    assert measured["bytes"] / 3.0 < planned["bytes"] < 3.0 * measured["bytes"]
    assert planned["pilot_s"] == rates.pilot_s
    stored = sum(
        cost["bytes_written"] for record in records.commits(tmp_path / "out") for cost in record["costs"]
    )
    assert measured["bytes"] == stored


def test_rates_are_remembered(rates, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(pilot, "_measure_apart", lambda name: rates)
    pilot.rates.cache_clear()
    assert pilot.rates() == rates
    assert [path.suffix for path in (tmp_path / "railvib").iterdir()] == [".json"]
    monkeypatch.setattr(pilot, "_measure_apart", lambda name: pytest.fail("measured twice"))
    pilot.rates.cache_clear()
    assert pilot.rates() == rates
    monkeypatch.setattr("socket.gethostname", lambda: "another")
    pilot.rates.cache_clear()
    with pytest.raises(pytest.fail.Exception, match="measured twice"):
        pilot.rates()


@pytest.mark.parametrize(
    ("sections", "sort"),
    [
        ({"receivers": {"offsets_m": [8, 64]}}, "transfer"),
        ({"frequency": {"minimum_hz": 4.0, "maximum_hz": 63.0}}, "full"),
        ({"train": {"single": {"vehicles": [{"vehicle": "regina", "number": 8}]}}}, "moving roughness"),
        ({"sweep": tomllib.loads(STUDY)["sweep"] | {"soil": ["greby"]}}, "transfer"),
    ],
)
def test_more_work_takes_longer(sections, sort, rates, tmp_path):
    def cpu(made):
        return sum(
            rates.of(amounts)
            for amounts in (work(task.units) for task in made.plan.tasks.values())
            if amounts.sort == sort
        )

    assert cpu(request(tmp_path, **sections)) > cpu(request(tmp_path))


def test_more_receivers_than_are_held_at_once_take_no_more_memory(rates, tmp_path):
    few, many = (
        estimate.estimate(request(tmp_path, receivers={"rail": False, "offsets_m": offsets}), rates)
        for offsets in ([100.0 - 0.1 * n for n in range(count)] for count in (250, 750))
    )
    assert many.peak_memory_bytes == pytest.approx(few.peak_memory_bytes, rel=0.02)
    assert many.bytes > 2.0 * few.bytes


@pytest.mark.slow
def test_a_worker_without_work_has_its_kernels_whoever_forks_it():
    """Runs of other stages in the process that measured had once left the kernels out."""

    def idle(stages):
        environment = {**os.environ, **forks.THREADS, forks.STAGES_MODULE: stages}
        command = [sys.executable, "-m", "sweep.forecast.pilot", "pilot"]
        measured = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True)
        return json.loads(measured.stdout)["idle_bytes"]

    assert idle("tests.sweep.toy") == pytest.approx(idle("railvib.stages"), rel=0.1)


def test_rates_are_found_from_samples():
    amounts = [{"units": 1.0, "lines": 10.0 * count} for count in (1, 3, 9)]
    samples = [pilot._Sample(Work("another", amount), 0.5 + 0.02 * amount["lines"], {}) for amount in amounts]
    found = pilot._rates(samples)
    assert found == pytest.approx({"units": 0.5, "lines": 0.02})


def refusal(made, planned, rates, tmp_path, workers=2, memory=16 * GB):
    with pytest.raises(InputError) as refused:
        estimate.check(made, planned, rates, tmp_path, workers, memory)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_what_cannot_fit_is_refused_and_the_axis_named(rates, tmp_path):
    axes = tomllib.loads(STUDY)["sweep"]
    made = request(tmp_path, sweep=axes | {"speed_kmh": [30, 40, 50, 60]})
    planned = estimate.estimate(made, rates)
    estimate.check(made, planned, rates, tmp_path, 2, 16 * GB)
    of = {**planned.document}
    disk = refusal(made, estimate.Estimate(**of | {"bytes": 10**18}), rates, tmp_path)
    assert re.match(r"sweep\.speed_kmh \(4 values\) makes most of 1\.5e\+06 TB of results; ", disk)
    memory = refusal(made, planned, rates, tmp_path, memory=planned.peak_memory_bytes - 1)
    assert re.match(r"receivers\.offsets_m = 8 m makes a worker need .* of memory; this machine has", memory)
    many = refusal(made, planned, rates, tmp_path, workers=3, memory=2 * planned.peak_memory_bytes)
    assert many.startswith("--workers = 3: each may need")
    assert many.endswith("must be at most 2")
    time = refusal(made, estimate.Estimate(**of | {"cpu_s": 1e8}), rates, tmp_path)
    assert "sweep.speed_kmh (4 values) makes most of 3.17 years of processor time" in time
    estimate.check(made, estimate.Estimate(**of | {"cpu_s": 1e8}), rates, tmp_path, None, GB)


def test_a_long_train_is_named_where_it_takes_the_memory(rates, tmp_path):
    train = {"single": {"vehicles": [{"vehicle": "regina", "number": 60}]}}
    made = request(tmp_path, train=train)
    told = refusal(made, estimate.estimate(made, rates), rates, tmp_path, memory=GB)
    assert told.startswith("sweep.train = 'single' (240 axles) makes a worker need")
    slow = estimate.Estimate(**estimate.estimate(made, rates).document | {"cpu_s": 1e8})
    told = refusal(made, slow, rates, tmp_path, memory=1000 * GB)
    assert told.startswith("sweep.train = 'single' (240 axles) makes most of 3.17 years of processor time")


def test_plan_refuses_as_run_does(tmp_path, monkeypatch):
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    monkeypatch.setattr("shutil.disk_usage", lambda path: type("Usage", (), {"free": 1000})())
    for command in ("plan", "run"):
        result = invoke(command, tmp_path / "small.toml", "--out", tmp_path / "out")
        assert result.exit_code == 2
        assert "has 1 kB free" in result.output
    assert not (tmp_path / "out").exists()


def test_the_plan_tells_time_and_memory(tmp_path):
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    output = invoke("plan", tmp_path / "small.toml", "--out", tmp_path / "out").output
    assert re.search(r"memory +\d+ MB per worker at most", output)
    assert re.search(r"processor +[\d.]+ s, .* with \d+ workers, from a pilot of [\d.]+ s", output)


def test_too_many_cases_are_refused_before_they_are_counted_out(tmp_path):
    axes = tomllib.loads(STUDY)["sweep"]
    speeds = {"start": 10, "stop": 110, "number": 100_000}
    with pytest.raises(
        InputError, match=r"sweep\.speed_kmh: 100000 values make 400000 cases; must be at most"
    ):
        request(
            tmp_path,
            sweep=axes | {"speed_kmh": speeds, "unevenness": [f"fra-hamid-yang-{n}" for n in (1, 2, 3, 4)]},
        )
