"""Running levels against printed bursts and sines of ISO 8041-1 and DIN 45669-1, and closed forms."""

import numpy as np
import pytest
from pyoctaveband import time_weighting

from railvib.levels import running
from railvib.levels.weightings import WEIGHTINGS, weighted
from tests.data.levels import golden
from tests.data.levels.oracle import sawtooth

DURATION = 10.0
BURSTS_IN_A_MINUTE = 6
TOLERANCE = {"rms": 0.10, "VDV": 0.12, "MTVV_linear": 0.10, "MTVV_exponential": 0.10}
"""Of ISO 8041-1:2017 table 8."""


def indications(weighting, cycles):
    """Return what a meter shows after a minute of bursts."""
    signal, step = sawtooth(cycles, 400, DURATION)
    response = WEIGHTINGS["wk"] if weighting == "band" else WEIGHTINGS[weighting.lower()]
    if weighting == "band":
        signal = weighted(signal, step, golden.band_limit_of_iso_8041, response.rest)
    else:
        signal = weighted(signal, step, response.response, response.rest)
    minute = BURSTS_IN_A_MINUTE * DURATION / 60.0
    return {
        "rms": running.rms(signal) * np.sqrt(minute),
        "VDV": running.vdv(signal, step) * BURSTS_IN_A_MINUTE**0.25,
        "MTVV_linear": running.mtvv_linear(signal, step),
        "MTVV_exponential": running.mtvv_exponential(signal, step),
    }


@pytest.mark.parametrize("weighting", ["band", "Wb", "Wd", "Wk", "Wm"])
@pytest.mark.parametrize("cycles", [1, 2, 4, 8, 16])
def test_bursts_of_iso_8041_1(weighting, cycles):
    shown = indications(weighting, cycles)
    rows = [
        row
        for row in golden.rows("iso8041_bursts")
        if (row["weighting"], row["cycles"]) == (weighting, str(cycles))
    ]
    assert len(rows) == len(TOLERANCE)
    for row in rows:
        value, printed = shown[row["quantity"]], float(row["printed_iso_8041_1_table_8"])
        assert value == pytest.approx(printed, rel=min(0.02, TOLERANCE[row["quantity"]]))
        assert value == pytest.approx(float(row["oracle"]), rel=1e-3)


@pytest.mark.parametrize("frequency", ["1", "5.6", "16", "31.5", "80", "315"])
def test_kb_f_of_sines(frequency):
    """DIN 45669-1:2010 table 9: 1 mm/s, shown with three digits."""
    step = 1.0 / 16_000.0
    t = step * np.arange(round(10.0 / step))
    shown = running.kb_f(1e-3 * np.sin(2.0 * np.pi * float(frequency) * t), step)[t >= 5.0]
    for row in golden.rows("din"):
        if (row["case"], row["argument"]) == ("sine", frequency):
            value = shown.max() if row["quantity"] == "KB_Fmax" else shown.mean()
            assert value == pytest.approx(float(row["printed"]), abs=1e-3)
            assert value == pytest.approx(float(row["oracle"]), rel=2e-4)


def test_kb_f_of_bursts():
    """DIN 45669-1:2010, table 8 as corrected in 2012: per cent of what a continuous sine shows."""
    step = 1.0 / 16_000.0
    t = step * np.arange(round(8.0 / step))
    carrier = 1e-3 * np.sin(2.0 * np.pi * 80.0 * t)
    late = t >= 4.0
    continuous = running.kb_f(carrier, step)[late].mean()
    rows = [row for row in golden.rows("din") if row["case"] == "burst_80Hz"]
    assert len(rows) == 8
    for row in rows:
        gate = np.mod(t, 1.0) < float(row["argument"]) / 1e3
        shown = 100.0 * running.kb_f(carrier * gate, step)[late].max() / continuous
        assert shown == pytest.approx(float(row["oracle"]), abs=0.02)
        assert shown == pytest.approx(float(row["printed"]), abs=0.6)


def test_running_mean_squares_against_another_library():
    rate = 2000
    signal = np.random.default_rng(4).normal(size=4 * rate).cumsum()
    for mode, time_constant in (("fast", running.FAST), ("slow", running.SLOW)):
        expected = time_weighting(signal, rate, mode)
        value = running.exponential_mean_square(signal, 1.0 / rate, time_constant)
        # The library holds each square for a step, railvib interpolates between them.
        np.testing.assert_allclose(value, expected, atol=5e-3 * expected.max())
        assert running.running_maximum(value) == pytest.approx(np.sqrt(expected.max()), rel=1e-3)


def test_exponential_window_of_a_constant():
    step = 0.01
    t = step * np.arange(200)
    value = running.exponential_mean_square(np.full((2, 200), 3.0), step, running.FAST)
    # From rest the signal rises within the first step.
    start = value[:, :1]
    np.testing.assert_allclose(value, 9.0 + (start - 9.0) * np.exp(-t / running.FAST), rtol=1e-12)


@pytest.mark.parametrize("window", [0.5, 0.4987, 5.0])
def test_linear_window_of_a_ramp(window):
    """∫ (s²) ds over the window, where v² is a straight line: exact at any window."""
    step = 0.01
    t = step * np.arange(400)
    value = running.linear_mean_square(np.sqrt(t), step, window)
    start = np.maximum(t - window, 0.0)
    np.testing.assert_allclose(value, (t**2 - start**2) / 2.0 / window, atol=1e-12)


def test_dose_of_a_sine():
    """(3/8 a⁴ T)^¼."""
    step, duration = 1e-3, 8.0
    signal = 2.0 * np.sin(2.0 * np.pi * 5.0 * step * np.arange(8000))
    assert running.vdv(signal, step) == pytest.approx((0.375 * 16.0 * duration) ** 0.25, rel=1e-9)
    assert running.evdv(np.sqrt(2.0), duration) == pytest.approx(1.4 * np.sqrt(2.0) * 8.0**0.25)


def test_event_velocity():
    """DIN 45672-2: the constant velocity of an hour with the energy of the passage."""
    assert running.event_velocity(0.6, 9.0) == pytest.approx(0.6 * np.sqrt(9.0 / 3600.0))


@pytest.mark.parametrize(("samples", "error"), [(9.2, 7e-3), (18.4, 1e-3)])
def test_peak_between_samples(samples, error):
    """A sine with an envelope, at many phases."""
    phase = np.linspace(0.0, 2.0 * np.pi, 97)[:, None]

    def burst(at):
        return np.sin(2.0 * np.pi / samples * at + phase) * np.exp(-(((at - 30.0) / 15.0) ** 2))

    exact = np.abs(burst(np.linspace(0.0, 60.0, 60_001))).max(axis=1)
    coarse = burst(np.arange(61.0))
    np.testing.assert_allclose(running.peak(coarse), exact, rtol=error)
    assert np.max(1.0 - np.abs(coarse).max(axis=1) / exact) > 5.0 * error
