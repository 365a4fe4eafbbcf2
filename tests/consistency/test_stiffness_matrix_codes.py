"""Q33 against three independent stiffness-matrix implementations, agreeing among themselves to 8 digits."""

import math

import pytest

from railvib.soil.flexibility import ground_flexibility
from tests.consistency.reference import damped, rows

GROUND = {
    # c(1 + 0.025i): speeds squared times 1 − 0.025² + 0.05i
    "c*(1+0.025i)": lambda greby: damped(greby, 0.05 / 0.999375, math.sqrt(0.999375)),
    "mu*(1+0.05i)": lambda greby: damped(greby, 0.05),
}


@pytest.mark.parametrize("row", rows("ground_flexibility"), ids=lambda row: "-".join(list(row.values())[:3]))
def test_flexibility(row, greby):
    expected = complex(float(row["real_m_pa"]), float(row["imag_m_pa"]))
    q = ground_flexibility(
        GROUND[row["damping"]](greby), float(row["wavenumber_rad_m"]), float(row["frequency_hz"])
    )
    assert abs(q / expected - 1.0) < 3e-8  # the file has 9 digits, the codes 8 in common
