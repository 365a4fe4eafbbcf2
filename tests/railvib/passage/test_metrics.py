import numpy as np
import pytest

from railvib.levels.weightings import WEIGHTINGS, third_octave
from railvib.parameters.metric import METRICS
from railvib.passage.metrics import SKIRT, signals

FREQUENCY = 0.5 * np.arange(2, 200)
BAND = 10.0 ** (np.arange(5, 19) / 10.0)


def test_every_metric_is_read_once():
    readings = [reading for each in signals(METRICS, FREQUENCY, BAND) for reading in each.readings]
    names = [reading.name for reading in readings]
    assert len(set(names)) == len(names)
    assert {name.split(" ")[0] for name in names} == set(METRICS)
    assert names.count("third-octave-max-fast 31.5 Hz") == 1


@pytest.mark.parametrize(("metric", "weighting"), [("kb-f-max", "kb"), ("vdv", "wb")])
def test_weightings_act_on_velocity(metric, weighting):
    (signal,) = signals((metric,), FREQUENCY, BAND)
    np.testing.assert_array_equal(signal.response, WEIGHTINGS[weighting].of_velocity(FREQUENCY))


def test_metrics_of_one_signal_share_it():
    (signal,) = signals(("ppv", "v-max-slow", "v-max-fast"), FREQUENCY, BAND)
    assert [reading.name for reading in signal.readings] == ["ppv", "v-max-slow", "v-max-fast"]


def test_what_lies_beyond_the_skirts_of_a_band_does_not_count():
    midband = float(BAND[5])
    signal = list(signals(("third-octave-max-fast",), FREQUENCY, BAND))[5]
    inside = FREQUENCY[signal.lines]
    assert inside[0] >= midband / SKIRT
    assert inside[-1] <= midband * SKIRT
    assert np.abs(third_octave(midband)(np.array([midband * SKIRT]))) ** 2 < 1e-6
