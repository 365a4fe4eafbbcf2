"""Force density and line-source mobility against closed forms, in SI and US units."""

import numpy as np
import pytest

from railvib.levels import force_density, references
from tests.data.levels import golden

VALUE = {row["what"]: float(row["value"]) for row in golden.rows("units_and_lines")}


@pytest.mark.parametrize("spacing", [2.5, 5.0, 10.0, 25.0])
def test_line_mobility_of_impacts(spacing):
    """|Y|² = 1/(x² + 20²) along 100 m."""
    x = np.arange(-50.0, 50.1, spacing)
    level = force_density.line_mobility_of_impacts(-10.0 * np.log10(x**2 + 400.0), spacing)
    assert level == pytest.approx(VALUE[f"the same by FTA's sum, h = {spacing:g} m"], abs=1e-7)
    exact = VALUE["TM_L of |Y|^2 = 1/(x^2+20^2) m^-2, L = 100 m, exact"]
    assert level == pytest.approx(exact, abs=0.002 if spacing <= 5.0 else 0.04)


def test_offsets_between_units():
    density = VALUE["L_F(SI, re 1 N/m^(1/2)) minus L_F(FTA)"]
    mobility = VALUE["TM(SI, re 1e-9 (m/s)/(N/m^(1/2))) minus TM(FTA)"]
    assert pytest.approx(density, abs=1e-6) == force_density.FORCE_DENSITY_OFFSET
    assert pytest.approx(mobility, abs=1e-6) == force_density.LINE_MOBILITY_OFFSET
    assert density + mobility == pytest.approx(VALUE["dB re 1e-9 m/s minus VdB"], abs=1e-6)


def test_sum_of_levels_is_the_velocity_level_in_either_unit():
    """v² = S' ∫ |Y|² dx with S' of two axles over 50 m."""
    force = np.array([[3e6, 5e6], [1e6, 2e6]])
    mobility = np.array([2e-17, 7e-18])
    square = force.sum(axis=0) / 50.0 * mobility
    for velocity, per_length, line in (
        (references.VELOCITY, references.FORCE_DENSITY, references.LINE_MOBILITY),
        (references.VELOCITY_US, references.FORCE_DENSITY_US, references.LINE_MOBILITY_US),
    ):
        total = force_density.force_density_level(force, 50.0, per_length) + references.level(mobility, line)
        np.testing.assert_allclose(total, references.level(square, velocity))
