"""Phase speeds of the Rayleigh modes against disba."""

import itertools

import numpy as np
import pytest

from railvib.soil.surface_waves import surface_wave_speeds
from tests.consistency.reference import damped, rows

RAYLEIGH = [row for row in rows("rayleigh_love_greby") if row["mode"].startswith("R")]
FREQUENCIES = sorted({float(row["frequency_hz"]) for row in RAYLEIGH})


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_rayleigh_modes(frequency, greby):
    expected = {
        row["mode"]: float(row["phase_speed_m_s"])
        for row in RAYLEIGH
        if float(row["frequency_hz"]) == frequency
    }
    speeds = surface_wave_speeds(damped(greby, 1e-4), frequency)
    assert np.all(np.diff(speeds) > 0.0)
    for mode, speed in expected.items():
        # Damping of 1e-4 shifts a mode by about 1e-8; the table is good to 1e-6 and has six digits.
        assert speeds[int(mode[1:])] == pytest.approx(speed, rel=1e-5)


def test_fundamental_mode_is_continuous(greby):
    nearly_elastic = damped(greby, 1e-4)
    speeds = [surface_wave_speeds(nearly_elastic, f)[0] for f in np.geomspace(1.0, 100.0, 25)]
    assert all(later < earlier for earlier, later in itertools.pairwise(speeds))
