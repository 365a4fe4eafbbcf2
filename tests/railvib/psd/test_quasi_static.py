"""The response to moving axle loads, where tables end and beyond."""

import numpy as np
import pytest

from railvib.parameters.receiver import CENTRE, RAIL, Receiver
from railvib.psd.quasi_static import quasi_static_spectra
from railvib.transfer.highest_frequencies import highest_quasi_static_frequency
from railvib.transfer.nodes import largest_wavenumber
from tests.railvib.transfer.soft_ground import SOFT

SPEED = 10.0


@pytest.fixture(scope="module")
def psd(track, tables):
    """PSDs of one axle of 1 N at 10 m/s, from below the end of the tables to well beyond it."""
    highest = largest_wavenumber(track) * SPEED / (2.0 * np.pi)
    frequency = highest * np.geomspace(0.5, 8.0, 201)
    functions = tables(SOFT, track, range(1, 3), (RAIL, CENTRE, Receiver(8.0)))
    assert functions[RAIL].highest < frequency[-1]
    one = np.array([0.0]), np.array([1.0])
    return frequency, quasi_static_spectra(SOFT, track, functions, *one, 1.0, SPEED, frequency)


@pytest.mark.parametrize("receiver", [RAIL, CENTRE])
def test_the_track_answers_beyond_the_tables_without_a_step(receiver, psd):
    """A power of frequency in sight of every neighbour: the tables' end leaves no step of 1 %."""
    frequency, density = psd
    level = np.log(density[receiver])
    assert np.all(np.isfinite(level))
    second = np.diff(level, 2) / np.diff(np.log(frequency))[0] ** 2
    assert np.abs(np.diff(level, 2)).max() < 0.01
    assert np.all(np.diff(level) < 0.0)
    assert np.isfinite(second).all()


def test_the_rail_is_a_beam_far_beyond(psd, track):
    """EI β⁴ − mω² alone: the pads' share falls as β⁻⁴."""
    frequency, density = psd
    beta, omega = 2.0 * np.pi * frequency[-1] / SPEED, 2.0 * np.pi * frequency[-1]
    beam = track.rail_bending_stiffness * beta**4 - track.rail_mass * omega**2
    expected = 2.0 * SPEED / (SPEED * np.abs(beam)) ** 2
    assert density[RAIL][-1] == pytest.approx(expected, rel=0.05)  # the rail's own damping counts too


def test_far_ground_hears_nothing_there(psd):
    assert np.all(psd[1][Receiver(8.0)][100:] == 0.0)


def test_tables_are_needed_as_far_as_they_serve(track):
    on_rail = highest_quasi_static_frequency(SOFT, track, RAIL, SPEED)
    assert on_rail == pytest.approx(largest_wavenumber(track) * SPEED / (2.0 * np.pi))
    assert highest_quasi_static_frequency(SOFT, track, Receiver(50.0), SPEED) < on_rail
    assert highest_quasi_static_frequency(SOFT, track, RAIL, 100.0) == np.inf  # a wave can follow
