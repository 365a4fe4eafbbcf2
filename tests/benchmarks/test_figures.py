"""Figures with their samples, targets and slopes."""

import pytest

from benchmarks.figures import Figure, slope, time_call


def test_a_figure_tells_whether_it_meets_its_target():
    figure = Figure("kernel", "x", "y", "z", "s", (1.0, 2.0, 4.0), at_most=2.0)
    assert (figure.median, figure.quantile(0.25), figure.holds) == (2.0, 1.5, True)
    assert Figure("kernel", "x", "y", "z", "s", (1.0,), at_least=2.0).holds is False
    assert Figure("kernel", "x", "y", "z", "s", (1.0,)).holds is None


def test_slope_is_the_exponent_of_a_power_law():
    assert slope([1, 2, 4], [3, 12, 48]) == pytest.approx(2.0)


def test_a_call_is_sampled_after_warming_up():
    calls = []
    timing = time_call(lambda: calls.append(1), 3, 0.0)
    assert len(timing.cpu_s) == len(timing.wall_s) == 3
    assert len(calls) == 1 + 3
