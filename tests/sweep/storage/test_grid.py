import dask.array
import numpy as np
import pytest

import sweep
from railvib.numerics import frequency_blocks as blocks
from sweep.storage import records, store
from tests.sweep.small import STUDY, invoke


@pytest.fixture(scope="module")
def grid(computed):
    return sweep.open_grid(computed / "out")


def test_the_grid_is_lazy_and_named(grid):
    assert grid.transfer.dims == ("soil", "track", "receiver", "frequency", "node")
    assert grid.rail_moving.dims == ("soil", "track", "speed_kmh", "frequency", "moving_node")
    assert isinstance(grid.transfer.data, dask.array.Array)
    assert grid.speed_kmh.values.tolist() == [30.0]
    assert grid.receiver.values.tolist() == ["rail", "8.0"]
    assert grid.offset_m.values[1] == 8.0
    assert np.all(np.diff(grid.frequency.values) > 0.0)


def inside(arrays, block):
    low, high = blocks.edges(block)
    return (arrays["frequency"] > low * (1 - 1e-9)) & (arrays["frequency"] < high * (1 - 1e-9))


def test_the_grid_holds_what_is_stored(computed, grid):
    column = grid.sel(soil="horstwalde", track="ballasted-paper").compute()
    for record in records.commits(computed / "out", "transfer"):
        arrays, attributes = store.read_result(computed / "out", record)
        stored = arrays["rail" if record["inputs"]["receiver"] == "rail" else "ground"]
        assert attributes["receiver"] in arrays
        kept = inside(arrays, record["inputs"]["block"])
        count = arrays["wavenumber"].shape[1]
        here = column.sel(receiver=str(record["inputs"]["receiver"]), frequency=arrays["frequency"][kept])
        np.testing.assert_array_equal(here.transfer.values[:, :count], stored[kept])
        np.testing.assert_array_equal(here.wavenumber.values[:, :count], arrays["wavenumber"][kept])
        assert np.isnan(here.transfer.values[:, count:]).all()


def test_it_holds_nothing_else(computed, grid):
    rows = sum(
        inside(store.read_result(computed / "out", record)[0], record["inputs"]["block"]).sum()
        for record in records.commits(computed / "out", "transfer")
    )
    assert np.isfinite(grid.wavenumber.isel(node=0).values).sum() == rows


def test_moving_loads_are_those_of_the_full_model(computed, grid):
    column = grid.sel(soil="horstwalde", track="ballasted-paper").compute()
    for record in records.commits(computed / "out", "moving_transfer"):
        arrays, _attributes = store.read_result(computed / "out", record)
        assert len(record["inputs"]["blocks"]) > 1
        here = column.sel(speed_kmh=30.0, frequency=arrays["frequency"])
        np.testing.assert_array_equal(here.rail_moving.values, arrays["rail_moving"])
        np.testing.assert_array_equal(here.moving_wavenumber.values, arrays["wavenumber"])


def test_without_a_full_model_nothing_moves(tmp_path, monkeypatch):
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    text = STUDY.replace('["moving-roughness", "full"]', '["moving-roughness"]')
    text = text.replace('reference = "full"', 'reference = "moving-roughness"')
    (tmp_path / "standing.toml").write_text(text, encoding="utf-8")
    result = invoke("run", tmp_path / "standing.toml", "--out", tmp_path / "out", "--workers", 0)
    assert result.exit_code == 0, result.output
    grid = sweep.open_grid(tmp_path / "out")
    assert "transfer" in grid
    assert "rail_moving" not in grid
    assert grid.speed_kmh.size == 0


def test_no_run_no_grid(tmp_path):
    with pytest.raises(FileNotFoundError):
        sweep.open_grid(tmp_path)
