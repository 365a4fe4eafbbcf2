"""Levels, and the offsets between their references against tests/data/levels/units_and_lines.csv."""

import numpy as np
import pytest

from railvib.levels import references
from tests.data.levels import golden


def test_levels():
    mean_square = np.array([1e-6, 0.0]) ** 2
    assert references.level(mean_square, references.VELOCITY)[0] == pytest.approx(60.0)
    assert references.level(mean_square, references.VELOCITY)[1] == -np.inf
    levels = np.array([31.5, -4.0])
    square = references.mean_square(levels, references.VELOCITY_US)
    np.testing.assert_allclose(references.level(square, references.VELOCITY_US), levels)


def test_offsets_between_references():
    offset = {row["what"]: float(row["value"]) for row in golden.rows("units_and_lines")}

    def difference(one, other):
        return float(references.level(1.0, one) - references.level(1.0, other))

    for what, one, other in (
        ("dB re 1e-9 m/s minus VdB", references.VELOCITY, references.VELOCITY_US),
        ("dB re 1e-9 m/s minus dB re 5e-8 m/s", references.VELOCITY, references.VELOCITY_DIN),
        ("dB re 5e-8 m/s minus VdB", references.VELOCITY_DIN, references.VELOCITY_US),
    ):
        assert difference(one, other) == pytest.approx(offset[what], abs=1e-7)
    pound_per_root_foot = offset["1 lb/ft^(1/2) in N/m^(1/2)"]
    assert pytest.approx(pound_per_root_foot, rel=1e-9) == references.FORCE_DENSITY_US
