"""The benchmark: its peers give what railvib gives, its counts are right, and it runs. Nothing is timed."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import (
    adaptive_quadrature,
    arithmetic,
    fourier_grid,
    growth,
    sameness,
    sizes,
    soils,
    stiffness_matrices,
    studies,
    transfer,
)
from benchmarks.cli import benchmark
from benchmarks.figures import Figure, slope, timed
from benchmarks.fourier_grid import ERROR, OFFSETS
from benchmarks.operations import Count, counted
from railvib.numerics.vector_math import LANES, reciprocal
from railvib.soil.flexibility import surface_flexibilities
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.strip import strip_compliances
from sweep import study
from tests.sweep.small import STUDY, invoke

TINY = {"samples": 1, "wavenumbers": 256, "bands": (20,), "textbook_s": 0.0}


@pytest.mark.parametrize("layers", [1, 3, 10])
@pytest.mark.parametrize("way", [stiffness_matrices.by_linear_algebra, stiffness_matrices.by_elimination])
@pytest.mark.parametrize("frequency", [2.0, 20.0, 80.0])
def test_stiffness_matrices_give_the_same_flexibility(layers, way, frequency):
    ground = soils.ground(layers)
    r = np.geomspace(0.05, 3.0, 40)
    ours = surface_flexibilities(r, 2.0 * np.pi * frequency, ground.stack(), False)
    np.testing.assert_allclose(way(ground, r, 2.0 * np.pi * frequency), ours, rtol=1e-7)


def test_stiffness_matrices_on_bedrock(greby):
    bottom = greby.layers[1].model_copy(update={"thickness": 6.0})
    ground = greby.model_copy(update={"layers": (greby.layers[0], bottom), "base": "rigid"})
    r = np.geomspace(0.05, 3.0, 40)
    ours = surface_flexibilities(r, 60.0, ground.stack(), True)
    for way in (stiffness_matrices.by_linear_algebra, stiffness_matrices.by_elimination):
        np.testing.assert_allclose(way(ground, r, 60.0), ours, rtol=1e-7)


@pytest.mark.parametrize(("soil", "frequency"), [("horstwalde", 20.0), ("greby", 5.0), ("greby", 100.0)])
def test_textbook_grid_reaches_the_error_and_no_coarser_one_does(soil, frequency, track, request):
    ground = request.getfixturevalue(soil)
    fit = fit_flexibility(ground, frequency, 1e-10)
    grid = fourier_grid.coarsest(ground, track, frequency, fit)
    flexibility = fourier_grid.kernel(ground, 2.0 * np.pi * frequency)
    surface_wave = 2.0 * np.pi * frequency / ground.slowest_speed
    rows = np.append(np.linspace(0.0, grid.along_range, 9), [0.93 * surface_wave, 1.02 * surface_wave])
    exact = fourier_grid.closed_form(fit, track.half_width, rows)
    found = [
        fourier_grid.by_transform(flexibility, track.half_width, rows, grid),
        fourier_grid.by_sums(flexibility, track.half_width, rows, grid, fourier_grid.cosines(grid)),
    ]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9, atol=1e-12 * abs(exact).max())
    assert (np.abs(found[0] - exact) / np.abs(exact[:, :1])).max() < 1.1 * ERROR


@pytest.mark.parametrize("frequency", [1.0, 30.0])
def test_adaptive_quadrature_agrees_with_the_closed_forms(greby, track, frequency):
    fit = fit_flexibility(greby, frequency, 1e-10)
    beta = transfer.wavenumbers(greby, track, frequency, 60)
    exact = fourier_grid.closed_form(fit, track.half_width, beta)
    found = adaptive_quadrature.compliances(greby, track.half_width, beta, OFFSETS, frequency, 1e-8)
    assert (np.abs(found - exact) / np.abs(exact[:, :1])).max() < 1e-6


def test_operations_of_known_formulas_are_counted():
    def total(call, *arguments):
        return vars(counted(call, arguments)[1])

    once = Count(additions=1, multiplications=4, divisions=1)
    assert total(reciprocal, 2.0 + 1.0j) == vars(once)  # |z|², a division, two products with it
    value, count = counted(reciprocal, (2.0 + 1.0j,))
    assert value == pytest.approx(1.0 / (2.0 + 1.0j))
    assert count.total == 6.0


def test_counted_kernels_compute_what_the_compiled_ones_do(greby):
    r = np.geomspace(0.1, 5.0, LANES)
    found, count = counted(surface_flexibilities, (r, 60.0, greby.stack(), False), plain=(3,))
    np.testing.assert_allclose(found, surface_flexibilities(r, 60.0, greby.stack(), False), rtol=1e-12)
    # Two layers and a half-space, each with roots of p and s: a complex root takes two.
    assert count.per(LANES).roots == 3 * 2 * 2
    fit = fit_flexibility(greby, 20.0, 1e-10)
    beta = np.linspace(0.0, 3.0, 5)
    arguments = (beta, fit.pole, fit.residue, fit.constant, 1.6, OFFSETS)
    found, count = counted(strip_compliances, arguments, STRETCH=1)
    for ours, theirs in zip(strip_compliances(*arguments), found, strict=True):
        np.testing.assert_allclose(theirs, ours, rtol=1e-10, atol=1e-12 * abs(ours).max())
    assert count.roots == 2 * beta.size * fit.pole.size


@pytest.mark.parametrize("length", [2, 4, 8])
def test_the_loops_that_find_the_limit_do_what_they_count(length):
    chains = 8
    each = length * chains
    start = length * sum(1.0 + 0.01 * i for i in range(chains))
    # x → 3/4 x + 1/2 tends to 2, the square root to 1, and 1.7/x returns after two passes.
    assert arithmetic.loop("fma", length, chains)(1) == pytest.approx(0.75 * start + 0.5 * each)
    assert arithmetic.loop("fma", length, chains)(200) == pytest.approx(2.0 * each)
    assert arithmetic.loop("root", length, chains)(200) == pytest.approx(1.0 * each)
    assert arithmetic.loop("divide", length, chains)(200) == pytest.approx(start)


def test_figures_say_whether_an_aim_is_reached():
    figure = Figure("kernel", "x", "y", "z", "s", (1.0, 2.0, 4.0), at_most=2.0)
    assert (figure.median, figure.quantile(0.25), figure.holds) == (2.0, 1.5, True)
    assert Figure("kernel", "x", "y", "z", "s", (1.0,), at_least=2.0).holds is False
    assert slope([1, 2, 4], [3, 12, 48]) == pytest.approx(2.0)
    calls = []
    assert len(timed(lambda: calls.append(1), 3, 0.0).cpu_s) == 3


def test_two_workers_give_what_one_gives(computed, tmp_path):
    """The tiny study in this process and by two workers, array by array."""
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sweep.cli.AFTER_RUN", "none")
        result = invoke("run", tmp_path / "small.toml", "--out", tmp_path / "two", "--workers", 2)
    assert result.exit_code == 0, result.output
    difference, arrays = sameness.largest_difference(computed / "out", tmp_path / "two")
    assert arrays > 20
    assert difference <= 1e-12


def test_the_program_measures_a_tiny_size(tmp_path, monkeypatch):
    monkeypatch.setitem(sizes.SIZES, "quick", replace(sizes.QUICK, **TINY))
    arguments = ["--size", "quick", "--only", "transfer,kernel", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(benchmark, arguments)
    assert result.exit_code == 0, result.output
    (file,) = (tmp_path / "out").glob("benchmark-*.json")
    document = json.loads(file.read_text(encoding="utf-8"))
    figures = document["figures"]
    assert {figure["section"] for figure in figures} == {"kernel", "transfer"}
    errors = [figure for figure in figures if figure["quantity"].startswith("error")]
    assert len(errors) == 3 * len(transfer.SOILS)
    assert all(figure["holds"] for figure in errors)
    assert {"railvib", "numba"} <= document["versions"].keys()
    assert (tmp_path / "out" / "benchmarks.duckdb").is_file()


def test_a_run_is_measured_with_its_growth(tmp_path):
    tiny = replace(sizes.QUICK, bands_hz=(8.0, 10.0), offsets_m=(8.0,))
    ran = growth.run(tiny, "layers", 2, tmp_path / "out")
    assert ran.first_task_s is not None
    assert 0.0 < ran.first_task_s < ran.wall_s
    assert 0.0 < ran.computing_s < ran.cpu_s
    assert ran.peak_bytes > 1e8
    assert {"transfer: fit", "transfer: transfer functions", "spectra: store"} <= ran.stages.keys()
    assert set(ran.approaches) == {"moving-roughness", "moving-roughness-uncorrelated", "full"}
    assert sum(ran.approaches.values()) > ran.computing_s  # what they share is charged to each
    files = [path for path in ran.directory.rglob("*") if path.is_file()]
    assert min(path.stat().st_size for path in files) > 0
    studies.empty(ran.directory)
    assert max(path.stat().st_size for path in files) == 0


def test_a_ratio_is_the_median_of_those_of_runs_in_turn(monkeypatch):
    """The machine becomes slower from turn to turn, which no ratio of one turn shows."""
    order = []

    def ran(size, axis, value, directory):
        earlier = [path for path in directory.parent.glob("*/result") if path.parent.name != "first"]
        assert [path.stat().st_size for path in earlier] == [0] * len(order[1:])  # emptied, not removed
        directory.mkdir()
        (directory / "result").write_bytes(b"much")
        turn = order[1:].count((axis, value))
        order.append((axis, value))
        spent = (1.0 + turn) * (4.0 + value)
        return studies.Ran(directory, 1.0, spent, 0.5, 1, {"spectra: bands": 1.0}, {"full": spent})

    monkeypatch.setattr(growth, "run", ran)
    axes = {"speeds": (1, 2, 4), "soils": (1, 2), "wavenumbers": (2, 4)}
    size = replace(sizes.QUICK, growth=axes, rounds=3)
    found = {(each.item, each.case, each.quantity): each for each in growth.measure(size)}
    assert [value for _, value in order[1:]] == [1, 2, 4, 1, 4, 1, 4, 1, 2, 1, 2, 1, 2]
    ratio = found["total", "speeds", "4 speeds over 1, cpu"]
    assert ratio.samples == (1.6, 1.6, 1.6)
    assert (ratio.at_most, ratio.holds) == (2.5, True)
    assert found["total", "speeds = 4", "cpu"].samples == (8.0, 16.0, 24.0)
    assert len(found["total", "speeds = 2", "cpu"].samples) == 1
    assert len(found["full", "one more speed", "cpu per 1,000 lines"].samples) == 3
    assert not any("over" in quantity for _, case, quantity in found if case == "soils")


@pytest.mark.parametrize("axis", sorted(sizes.FULL.growth.keys() - {"wavenumbers"}))
def test_studies_that_grow_are_valid(axis):
    count = {"frequencies": 50.0}.get(axis, 2)
    resolved = study.resolve(tomllib.loads(growth.text(sizes.FULL, axis, count)))
    expected = count if axis in ("trains", "soils", "speeds", "workers") else 1
    assert len(list(resolved.cases())) == expected
    soil = next(iter(resolved.canonical["soil"].values()))
    assert len(soil["layers"]) == (2 if axis == "layers" else 1 if axis == "workers" else 3)


def test_an_unknown_section_is_refused():
    result = CliRunner().invoke(benchmark, ["--only", "kernel,coffee"])
    assert result.exit_code == 2
    assert "'coffee'" in result.output
    assert "kernel, transfer, study, growth" in result.output
