"""Growth: the studies along each axis, the cost of a run, and ratios of runs in turn."""

import tomllib
from dataclasses import replace

import pytest

from benchmarks import sizes
from benchmarks.runs.process import RunCost, truncate
from benchmarks.sections import growth
from sweep import study


def test_a_run_is_measured(tmp_path):
    tiny = replace(sizes.QUICK, bands_hz=(8.0, 10.0), offsets_m=(8.0,))
    cost = growth.run(tiny, "layers", 2, tmp_path / "out")
    assert cost.first_task_s is not None
    assert 0.0 < cost.first_task_s < cost.wall_s
    assert 0.0 < cost.computing_s < cost.cpu_s
    assert cost.peak_bytes > 1e8
    assert {"transfer: fit", "transfer: transfer functions", "spectra: store"} <= cost.stages.keys()
    assert set(cost.approaches) == {"moving-roughness", "moving-roughness-uncorrelated", "full"}
    assert sum(cost.approaches.values()) > cost.computing_s  # shared work is charged to each
    files = [path for path in cost.directory.rglob("*") if path.is_file()]
    assert min(path.stat().st_size for path in files) > 0
    truncate(cost.directory)
    assert max(path.stat().st_size for path in files) == 0


def test_a_ratio_is_the_median_over_runs_in_turn(monkeypatch):
    """The machine becomes slower from turn to turn, and no ratio within one turn shows it."""
    order = []

    def run(size, axis, value, directory):
        earlier = [path for path in directory.parent.glob("*/result") if path.parent.name != "first"]
        assert [path.stat().st_size for path in earlier] == [0] * len(order[1:])  # truncated, not removed
        directory.mkdir()
        (directory / "result").write_bytes(b"much")
        turn = order[1:].count((axis, value))
        order.append((axis, value))
        seconds = (1.0 + turn) * (4.0 + value)
        return RunCost(directory, 1.0, seconds, 0.5, 1, {"spectra: bands": 1.0}, {"full": seconds})

    monkeypatch.setattr(growth, "run", run)
    axes = {"speeds": (1, 2, 4), "soils": (1, 2), "wavenumbers": (2, 4)}
    size = replace(sizes.QUICK, growth=axes, rounds=3)
    figures = {(figure.item, figure.case, figure.quantity): figure for figure in growth.measure(size)}
    assert [value for _, value in order[1:]] == [1, 2, 4, 1, 4, 1, 4, 1, 2, 1, 2, 1, 2]
    ratio = figures["total", "speeds", "4 speeds over 1, cpu"]
    assert ratio.samples == (1.6, 1.6, 1.6)
    assert (ratio.at_most, ratio.holds) == (2.5, True)
    assert figures["total", "speeds = 4", "cpu"].samples == (8.0, 16.0, 24.0)
    assert len(figures["total", "speeds = 2", "cpu"].samples) == 1
    assert len(figures["full", "one more speed", "cpu per 1,000 lines"].samples) == 3
    assert not any("over" in quantity for _, case, quantity in figures if case == "soils")


@pytest.mark.parametrize("axis", sorted(sizes.FULL.growth.keys() - {"wavenumbers"}))
def test_studies_that_grow_are_valid(axis):
    count = {"frequencies": 50.0}.get(axis, 2)
    resolved = study.resolve(tomllib.loads(growth.text(sizes.FULL, axis, count)))
    expected = count if axis in ("trains", "soils", "speeds", "workers") else 1
    assert len(list(resolved.cases())) == expected
    soil = next(iter(resolved.canonical["soil"].values()))
    assert len(soil["layers"]) == (2 if axis == "layers" else 1 if axis == "workers" else 3)
