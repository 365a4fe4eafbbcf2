"""Phase speeds of the Rayleigh modes against disba."""

import itertools
from collections import defaultdict

import numpy as np
import pytest

from railvib.parameters.ground import Ground, Layer
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


MODES = defaultdict(dict)
for row in rows("dispersion_modes"):
    MODES[row["model"], float(row["frequency_hz"])][int(row["mode"])] = float(row["speed_m_s"])


def model(name, loss_factor):
    return Ground(
        layers=[
            Layer(
                shear_speed=float(row["shear_speed_m_s"]),
                dilatational_speed=float(row["dilatational_speed_m_s"]),
                density=float(row["density_kg_m3"]),
                loss_factor=loss_factor,
                thickness=float(row["thickness_m"]) if row["thickness_m"] else None,
            )
            for row in rows("dispersion_models")
            if row["model"] == name
        ]
    )


@pytest.mark.parametrize("loss_factor", [0.0, 1e-5])
@pytest.mark.parametrize(("name", "frequency"), MODES)
def test_models_of_bug_reports(name, frequency, loss_factor):
    speeds = surface_wave_speeds(model(name, loss_factor), frequency)
    for mode, speed in MODES[name, frequency].items():
        assert speeds[mode] == pytest.approx(speed, abs=0.005)
