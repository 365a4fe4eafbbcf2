"""Where the transfer function is the same at every frequency, the passage is known in closed form.

U_n(t) = d/dt Σ_l q_l √Δβ e^{iβ_n(α_l + vt)} H(α_l + vt)
"""

from types import SimpleNamespace

import numpy as np
import pytest

from railvib.numerics.wavenumber_panels import nodes_between
from railvib.parameters.receiver import RAIL
from railvib.passage.full_model import full_model_amplitudes
from railvib.passage.grid import Grid
from railvib.passage.moments import over_time, variance_spectra
from railvib.passage.moving_roughness import moving_roughness_amplitudes

SPEED = 40.0
LENGTH = 50.0
POSITION = np.array([5.0, 7.5, 42.0, 44.5])
WIDTH = 3.0
"""H(x) = e^{−x²/2·WIDTH²}."""
GRID = Grid(0.1 * np.arange(20, 500), 0.1, 512.0, 64.0, 0.05, 7.0)
EDGES = np.linspace(0.0, 12.0, 49)


class Unchanging:
    """A transfer function that does not depend on frequency, tabulated as those of the product are."""

    nodes = SimpleNamespace(panel_edges=lambda f: np.broadcast_to(EDGES, (f.size, EDGES.size)))
    blocks = dict.fromkeys(range(-3, 5), SimpleNamespace(nodes=nodes))

    def at(self, _block, frequency):
        beta = np.broadcast_to(nodes_between(EDGES), (frequency.size, 12 * (EDGES.size - 1)))
        value = WIDTH * np.sqrt(2.0 * np.pi) * np.exp(-0.5 * (WIDTH * beta) ** 2)
        return beta, value.astype(complex)


@pytest.fixture(scope="module")
def excitation():
    """Forces of four unlike axles, from 1.5 to 5.5 rad/m (10 to 35 Hz), which are well inside the lines."""
    beta = GRID.wavenumber
    share = np.clip((beta - 1.5) / 4.0, 0.0, 1.0)
    forces = np.array([1.0, 0.7 + 0.4j, -0.5j, 1.2])
    return (np.sin(np.pi * share) ** 2 / beta)[:, None] * forces


def closed_form(excitation, samples):
    """Return Σ_n |U_n(t)|² over the record."""
    time = (np.arange(samples) / samples - 0.5) / GRID.step
    total = np.zeros(samples)
    for beta, width, q in zip(GRID.wavenumber, GRID.width, excitation, strict=True):
        x = POSITION[:, None] - 0.5 * LENGTH + SPEED * time
        slope = SPEED * (1j * beta - x / WIDTH**2)
        u = q @ (slope * np.exp(1j * beta * x - 0.5 * (x / WIDTH) ** 2))
        total += width * np.abs(u) ** 2
    return total


def variance(blocks, samples):
    everything = np.ones(GRID.frequency.size, complex)
    return over_time(variance_spectra(blocks, GRID, [everything], GRID.frequency.size), samples)[0]


def test_variance_over_time(excitation):
    """To 1e-4 of the largest: 1e-6 of every line's energy is left out on either side."""
    blocks = full_model_amplitudes(
        {RAIL: Unchanging()}, excitation[None], POSITION, LENGTH, SPEED, GRID, 100
    )[RAIL]
    samples = 4096
    exact = closed_form(excitation, samples)
    np.testing.assert_allclose(variance(blocks, samples), exact, rtol=0.0, atol=1e-4 * exact.max())


def test_every_set_of_unevenness_adds_its_variance(excitation):
    sets = np.stack([excitation, 2.0 * excitation])
    blocks = full_model_amplitudes({RAIL: Unchanging()}, sets, POSITION, LENGTH, SPEED, GRID, 100)[RAIL]
    exact = 5.0 * closed_form(excitation, 1024)
    np.testing.assert_allclose(variance(blocks, 1024), exact, rtol=0.0, atol=1e-4 * exact.max())


def test_moving_roughness_has_the_same_displacement(excitation):
    """It differs in the factor of velocity alone, that of the harmonic's frequency for that of the line."""
    own = GRID.wavenumber[:, None]
    blocks = list(
        moving_roughness_amplitudes(
            Unchanging(), (excitation / own)[None], POSITION - 0.5 * LENGTH, SPEED, GRID
        )
    )
    samples = 4096
    time = (np.arange(samples) / samples - 0.5) / GRID.step
    exact = np.zeros(samples)
    for beta, width, q in zip(GRID.wavenumber, GRID.width, excitation, strict=True):
        x = POSITION[:, None] - 0.5 * LENGTH + SPEED * time
        u = q @ (SPEED * np.exp(1j * beta * x - 0.5 * (x / WIDTH) ** 2))
        exact += width * np.abs(u) ** 2
    np.testing.assert_allclose(variance(blocks, samples), exact, rtol=0.0, atol=1e-3 * exact.max())
