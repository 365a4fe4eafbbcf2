"""Each file of reference numbers has a script beside it, and the scripts give its numbers."""

import cmath
from pathlib import Path

import numpy as np
import pytest

from tests.consistency.reference import DATA, rows
from tests.data import closed_forms, finite_elements, ground

FILES = sorted(path for path in DATA.rglob("*") if path.suffix in {".csv", ".json"})


def file_name(path):
    return str(path.relative_to(DATA))


@pytest.mark.parametrize("path", FILES, ids=file_name)
def test_a_script_beside_the_file_names_it(path):
    scripts = [script.read_text(encoding="utf-8") for script in path.parent.glob("*.py")]
    assert any(path.name in script or f'"{path.stem}"' in script for script in scripts)


@pytest.mark.parametrize("name", ["moving_load", "winkler_rail"])
def test_closed_forms_write_their_files(name):
    written = getattr(closed_forms, f"{name}_file")()
    assert written == Path(DATA / f"{name}.csv").read_text(encoding="utf-8")


def test_ground_flexibility():
    assert max(map(ground.flexibility_error, rows("ground_flexibility"))) < 1e-8


@pytest.mark.parametrize("row", rows("point_load")[::3], ids=lambda row: "-".join(list(row.values())[:3]))
def test_point_load(row):
    assert ground.point_load_error(row) < 1e-5  # the file is converged to that


def test_quadrature_columns_of_the_strip():
    """The file rounds wavenumbers to 1e-6 rad/m, which moves values near the surface wave by 1e-5."""
    for row in rows("fe_pml"):
        soil, wavenumber, offset, frequency, _, expected = finite_elements.strip_columns(row)
        under, value = finite_elements.compliance_by_quadrature(
            soil, wavenumber, [0.0, offset or 8.0], frequency
        )
        assert abs((value if offset else under) - expected) < 2e-5 * abs(under)


@pytest.mark.slow
def test_elements_of_the_strip():
    row = next(row for row in rows("fe_pml") if row["wavenumber_rad_m"] == "0.163412")
    soil, wavenumber, _, frequency, expected, _ = finite_elements.strip_columns(row)
    (value,) = finite_elements.compliance_by_elements(soil, wavenumber, [0.0], frequency)
    assert abs(value / expected - 1.0) < 1e-4  # one mesh; 1.3e-5


@pytest.mark.parametrize("row", rows("rail_receptance"), ids=lambda row: "-".join(list(row.values())[:3]))
def test_quadrature_columns_of_the_rail(row):
    expected = cmath.rect(float(row["semi_analytical_magnitude"]), float(row["semi_analytical_phase_rad"]))
    speed = float(row["speed_kmh"]) / 3.6
    value = finite_elements.rail_receptance(row["soil"], float(row["frequency_hz"]), speed)
    assert np.isclose(value, expected, rtol=1e-4, atol=0.0)  # the file's phases have five digits
