"""Runs are compared array by array."""

import numpy as np
import pytest

from benchmarks.runs import sameness
from tests.sweep.small import STUDY, invoke


def test_two_workers_give_what_one_process_gives(computed, tmp_path):
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sweep.hooks.AFTER_RUN", "none")
        result = invoke("run", tmp_path / "small.toml", "--out", tmp_path / "two", "--workers", 2)
    assert result.exit_code == 0, result.output
    difference, arrays = sameness.largest_difference(computed / "out", tmp_path / "two")
    assert arrays > 20
    assert difference <= 1e-12


@pytest.mark.parametrize(
    ("array", "other", "difference"),
    [
        ([0.0, 0.0], [0.0, 0.0], 0.0),
        ([0.0, 4.0], [1.0, 4.0], 0.25),
        ([0.0, 0.0], [1.0, 0.0], np.inf),
        ([1.0, np.nan], [1.0, np.nan], 0.0),
        ([1.0, np.nan], [1.0, 1.0], np.inf),
        ([1.0], [1.0, 1.0], np.inf),
    ],
)
def test_difference_of_two_arrays(array, other, difference):
    assert sameness._difference(np.array(array), np.array(other)) == difference
