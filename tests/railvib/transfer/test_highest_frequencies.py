"""Frequencies up to which transfer functions are needed: limits at rest, and growth with the speed."""

import numpy as np
import pytest

from railvib.parameters.receiver import RAIL, Receiver
from railvib.transfer.highest_frequencies import (
    highest_excitation,
    highest_quasi_static_frequency,
    highest_tabulated_frequency,
)
from railvib.transfer.nodes import TOP, largest_wavenumber


def test_a_standing_load_needs_no_frequency_but_its_own(track):
    assert highest_tabulated_frequency(track, 30.0, 0.0) == 30.0
    assert highest_excitation(30.0, largest_wavenumber(track), 0.0) == 30.0


@pytest.mark.parametrize("speed", [10.0, 60.0])
def test_a_moving_load_is_heard_at_frequencies_shifted_by_its_wavenumbers(track, speed):
    shift = largest_wavenumber(track) * speed / (2.0 * np.pi)
    assert highest_tabulated_frequency(track, 30.0, speed) == pytest.approx(30.0 + shift, rel=1e-14)
    assert highest_tabulated_frequency(track, 30.0, -speed) == highest_tabulated_frequency(track, 30.0, speed)
    assert 30.0 < highest_excitation(30.0, largest_wavenumber(track), speed) <= 30.0 + shift


def test_axle_loads_need_fewer_frequencies_far_away_and_all_where_a_wave_follows(track, horstwalde):
    receivers = (RAIL, Receiver(8.0), Receiver(32.0), Receiver(100.0))
    highest = [highest_quasi_static_frequency(horstwalde, track, receiver, 20.0) for receiver in receivers]
    assert highest == sorted(highest, reverse=True)
    assert highest[-1] < 0.2 * highest[1]
    doubled = highest_quasi_static_frequency(horstwalde, track, receivers[2], 40.0)
    assert doubled == pytest.approx(2.0 * highest[2], rel=1e-14)
    fast = 1.01 * horstwalde.slowest_speed / TOP
    assert highest_quasi_static_frequency(horstwalde, track, receivers[2], fast) == np.inf
