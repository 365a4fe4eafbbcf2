"""Point-load displacements against Hankel quadrature, whose method agrees with axitra (Fortran
reflectivity).
"""

import pytest

from railvib.soil.compliance import ground_green_function
from tests.consistency.reference import rows, soil


@pytest.mark.parametrize("row", rows("point_load"), ids=lambda row: "-".join(list(row.values())[:3]))
def test_point_load(row):
    expected = complex(float(row["real_m_n"]), float(row["imag_m_n"]))
    u = ground_green_function(soil(row["soil"]), float(row["distance_m"]), float(row["frequency_hz"]))
    assert abs(u / expected - 1.0) < 1e-4  # the table is converged to 1e-5
