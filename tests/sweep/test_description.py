import tomllib

import numpy as np
import pytest

from sweep import description, study
from tests.sweep.small import STUDY


@pytest.fixture(scope="module")
def resolved():
    return study.resolve(tomllib.loads(STUDY))


def test_the_leading_axle_is_the_first(resolved):
    (train,) = resolved.objects["train"].values()
    (axles,) = description.axles(resolved).values()
    behind = np.array([axle["behind_first_axle_m"] for axle in axles])
    assert behind[0] == 0.0
    assert np.all(np.diff(behind) > 0.0)
    assert behind[-1] == pytest.approx(np.ptp(train.axle_positions))
    assert [axle["receiver"] for axle in axles] == [f"axle-{number}" for number in range(1, len(axles) + 1)]
    assert sum(axle["axle_load_n"] for axle in axles) == pytest.approx(np.sum(train.axle_loads))


def test_every_layer_has_a_rayleigh_speed_a_little_below_that_of_its_shear_waves(resolved):
    for name, speeds in description.rayleigh_speeds(resolved).items():
        layers = resolved.objects["soil"][name].layers
        for layer, speed in zip(layers, speeds, strict=True):
            assert 0.8 * layer.shear_speed < speed < 0.96 * layer.shear_speed


def test_unevenness_covers_the_wavelengths_that_the_study_excites(resolved):
    sweep, frequency = resolved.study.sweep, resolved.study.frequency
    shortest = min(sweep.speed_kmh) / 3.6 / frequency.maximum_hz
    longest = max(sweep.speed_kmh) / 3.6 / frequency.minimum_hz
    for rows in description.unevenness_bands(resolved).values():
        wavelength = np.array([row["wavelength_m"] for row in rows])
        np.testing.assert_allclose(np.diff(np.log10(np.sort(wavelength))), 0.1)
        assert shortest <= wavelength.min() < shortest * 10.0**0.1
        assert longest >= wavelength.max() > longest / 10.0**0.1
        assert all(row["mean_square_m2"] > 0.0 and 0.0 <= row["extrapolated_share"] <= 1.0 for row in rows)
