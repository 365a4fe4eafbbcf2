"""What the paper states about its two soils, on the results of the real run.

The figures are read from the paper's text and plots, so each is held with 1 dB of tolerance.
"""

import numpy as np
import pytest

from railvib.numerics.third_octaves import midbands
from railvib.parameters.units import KMH

TOLERANCE = 1.0
BAND = midbands(1.0, 100.0)
SOILS = ["horstwalde", "greby"]
GROUND = [0.0, 8.0, 32.0, 100.0]
MR, UNCORRELATED, FULL = "moving-roughness", "moving-roughness-uncorrelated", "full"


def between(low: float, high: float) -> np.ndarray:
    """Return which bands lie between two nominal frequencies, both included."""
    return (BAND > 0.95 * low) & (BAND < 1.05 * high)


def receptance(results, soil: str, speed_kmh: float):
    rows = results.sql(
        "SELECT frequency_hz, receptance_re, receptance_im FROM receptances "
        "WHERE soil = $1 AND speed_kmh = $2 AND frequency_hz BETWEEN 1 AND 100 ORDER BY frequency_hz",
        (soil, speed_kmh),
    )
    return rows.frequency_hz.to_numpy(), np.abs(rows.receptance_re + 1j * rows.receptance_im).to_numpy()


def test_receptance_of_horstwalde_is_nearly_constant_and_falls_slowly_above_50_hz(results):
    frequency, size = receptance(results, "horstwalde", 0.0)
    level = 20.0 * np.log10(size / size[0])
    assert np.abs(level[frequency < 31.5]).max() < TOLERANCE
    assert np.all(np.diff(level[frequency > 31.5]) < 0.0)
    above = level[frequency > 50.0]
    assert np.all(np.diff(above) < 0.0)
    assert above[0] - above[-1] < 6.0


@pytest.mark.parametrize(("speed_kmh", "peak_hz"), [(0.0, 11.0), (150.0, 9.0)])
def test_receptance_of_greby_peaks_lower_under_a_moving_load(results, speed_kmh, peak_hz):
    frequency, size = receptance(results, "greby", speed_kmh)
    assert frequency[size.argmax()] == pytest.approx(peak_hz, abs=0.5)


@pytest.mark.parametrize("soil", SOILS)
def test_forces_of_both_approaches_agree(levels, soil):
    for axle in range(1, 17):
        difference = levels(soil, MR, f"axle-{axle}") - levels(soil, FULL, f"axle-{axle}")
        assert difference[between(1, 100)].abs().max() < 1.0 + 0.5 * TOLERANCE
    leading = levels(soil, MR, "axle-1") - levels(soil, FULL, "axle-1")
    trailing = levels(soil, MR, "axle-2") - levels(soil, FULL, "axle-2")
    assert max(leading.abs().max(), trailing.abs().max()) < 1.0


@pytest.mark.parametrize("soil", SOILS)
def test_trailing_axle_of_a_bogie_is_loaded_more_from_1_6_to_6_3_hz(levels, soil):
    difference = (levels(soil, MR, "axle-2") - levels(soil, MR, "axle-1"))[between(1.6, 6.3)]
    assert difference.min() > 1.6 - TOLERANCE
    assert difference.max() < 4.5 + TOLERANCE


@pytest.mark.parametrize("soil", SOILS)
def test_uncorrelated_axles_of_a_bogie_are_loaded_alike(levels, soil):
    difference = levels(soil, UNCORRELATED, "axle-2") - levels(soil, UNCORRELATED, "axle-1")
    assert difference[between(1, 31.5)].abs().max() < 0.2


def test_forces_hardly_depend_on_the_soil(levels):
    difference = levels("greby", MR, "axle-1") - levels("horstwalde", MR, "axle-1")
    assert difference[between(1, 31.5)].abs().max() < 1.5


def test_rail_vibrates_more_on_greby_at_low_and_less_at_high_frequency(levels):
    difference = levels("greby", MR, "rail") - levels("horstwalde", MR, "rail")
    low, high = difference[between(1, 31.5)], -difference[between(50, 100)]
    assert low.min() > 5.0 - TOLERANCE
    assert low.max() < 16.0 + TOLERANCE
    assert high.min() > 4.0 - TOLERANCE
    assert high.max() < 7.0 + TOLERANCE


@pytest.mark.parametrize("offset", GROUND)
@pytest.mark.parametrize("soil", SOILS)
def test_moving_roughness_follows_the_trend_of_the_full_model(levels, soil, offset):
    difference = levels(soil, MR, "ground", offset) - levels(soil, FULL, "ground", offset)
    above = difference[between(10, 100)]
    assert above.abs().max() < 6.0
    assert abs(above.mean()) < 1.5


@pytest.mark.parametrize("offset", GROUND)
def test_moving_roughness_lacks_the_detail_of_the_low_bands(levels, offset):
    difference = levels("horstwalde", MR, "ground", offset) - levels("horstwalde", FULL, "ground", offset)
    below = difference[between(1, 8)].abs()
    assert 6.0 < below.max() < 15.0 + TOLERANCE


def test_full_model_has_a_comb_at_multiples_of_speed_over_vehicle_length(results):
    psd = results.sql(
        "SELECT approach, frequency_hz, value FROM psd JOIN cases USING (case_id) WHERE soil = 'horstwalde' "
        "AND receiver = 'rail' AND contribution = 'dynamic' AND averaging = 'line' "
        "AND frequency_hz BETWEEN 5 AND 35 AND approach IN ('full', 'moving-roughness') ORDER BY frequency_hz"
    )
    spacing = 150.0 / KMH / 26.6
    swing = {}
    for approach, rows in psd.groupby("approach"):
        level = 10.0 * np.log10(rows.value.to_numpy())
        level -= np.convolve(level, np.ones(101) / 101, mode="same")
        phase = 2.0 * np.pi * rows.frequency_hz.to_numpy() / spacing
        swing[approach] = np.mean(level * np.cos(phase))  # half the height of the comb's first harmonic, dB
    assert swing[FULL] > 3.0
    assert abs(swing[MR]) < 0.5


def test_moving_roughness_costs_less(results):
    runtime = results.runtime
    for _soil, rows in runtime.groupby("soil"):
        cost = rows.set_index("approach").evaluations
        assert cost[MR] < cost[FULL]
        assert cost[UNCORRELATED] < cost[FULL]
