"""The excitation of the full model: panels that resolve it, and what the spectra gain by finer ones."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.ndimage import maximum_filter1d

from railvib.forces.receptance import tabulate_receptances
from railvib.numerics import third_octaves
from railvib.numerics.wavenumber_panels import ORDER
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.psd.excitation import excitation, resolve
from railvib.psd.full_model import passage_spectra
from railvib.psd.lines import lines

ALPHA = np.array([-9.0, 0.0, 14.0])
SPEED = 150.0 / KMH
ROUGH = Unevenness(form="fra-hamid-yang", line_class=3)


def sharp(beta):
    """Return amplitudes with a resonance, and with ripples from other axles."""
    resonance = 1.0 / (0.15**2 - beta**2 + 0.02j * 0.15 * beta)
    ripples = np.exp(1j * beta[:, None] * (ALPHA - 3.0))
    return resonance[:, None] * (1.0 + 0.1 * ripples)


def value(excited, axle, beta):
    """Return one axle's amplitude from its series."""
    panel = np.searchsorted(excited.edge, beta, side="right") - 1
    low, high = excited.edge[panel], excited.edge[panel + 1]
    x = (2.0 * beta - low - high) / (high - low)
    return np.array(
        [
            np.polynomial.legendre.legval(place, excited.series[axle, row])
            for place, row in zip(x, panel, strict=True)
        ]
    )


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_series_are_the_amplitudes(tolerance):
    excited = resolve(sharp, 40.0, ALPHA, tolerance=tolerance)
    beta = np.random.default_rng(3).uniform(1e-3, 40.0, 400)
    for axle in range(3):
        np.testing.assert_allclose(
            value(excited, axle, beta), sharp(beta)[:, axle], rtol=20.0 * tolerance, atol=0.0
        )


def test_narrow_where_it_is_sharp():
    width = np.diff(resolve(sharp, 40.0, ALPHA).edge)
    edge = resolve(sharp, 40.0, ALPHA).edge
    assert width[np.searchsorted(edge, 0.15) - 1] < 0.1 * width[-1]


def test_cut_offs_are_edges():
    edge = resolve(sharp, 40.0, ALPHA, (0.3, 7.7)).edge
    assert np.all(np.isin([0.3, 7.7], edge))
    assert np.all(np.isfinite(resolve(sharp, 40.0, ALPHA, (0.0, np.inf)).edge))


def test_refinement_divides_panels():
    usual, finer = resolve(sharp, 40.0, ALPHA), resolve(sharp, 40.0, ALPHA, refinement=3)
    np.testing.assert_allclose(finer.edge[::3], usual.edge, rtol=1e-14)
    assert finer.series.shape == (3, 3 * usual.series.shape[1], ORDER)


def test_turned_at_both_signs():
    """The four products give A = Σ φ_l q_l at β, and Σ φ_l q_l* at −β, in powers of x."""
    excited = resolve(sharp, 40.0, ALPHA)
    phase = np.exp(1j * np.random.default_rng(1).uniform(0.0, 6.0, (5, 3)))
    (rr, ri), (ir, ii) = excited.amplitude_parts(phase)
    terms = np.array([[legendre.leg2poly(panel) for panel in axle] for axle in excited.series]).reshape(3, -1)
    np.testing.assert_allclose((rr - ii) + 1j * (ri + ir), phase @ terms, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose((rr + ii) + 1j * (ir - ri), phase @ terms.conj(), rtol=1e-12, atol=1e-9)


def test_nothing_beyond_the_last_edge(track, tables):
    """An excitation that ends below 2πf/v is one that is cut off there."""
    soft = Ground(
        layers=[Layer(shear_speed=120.0, dilatational_speed=300.0, density=1800.0, loss_factor=0.1)]
    )
    functions = tables(soft, track, range(1, 3), (RAIL, Receiver(8.0)), 1e-4)
    f, end = np.array([6.0, 20.0]), 0.5
    assert np.all(2.0 * np.pi * f / SPEED > end)
    short = passage_spectra(functions, resolve(sharp, end, ALPHA), 50.0, SPEED, f)
    cut = passage_spectra(functions, resolve(sharp, 40.0, ALPHA, (0.0, end)), 50.0, SPEED, f)
    for receiver in functions:
        assert np.all(short[receiver] > 0.0)
        np.testing.assert_allclose(short[receiver], cut[receiver], rtol=1e-5)


@pytest.mark.parametrize("kmh", [80.0, 200.0])
def test_tolerance_is_kept_in_lines_and_bands(kmh, track, tables, train):
    """Against an excitation a hundred times as exact: three tolerances of what is around a line, one of a
    band.
    """
    speed = kmh / KMH
    soft = Ground(
        layers=[Layer(shear_speed=120.0, dilatational_speed=300.0, density=1800.0, loss_factor=0.1)]
    )
    functions = tables(soft, track, range(-3, 5), (RAIL, Receiver(8.0)), 1e-4)
    moving = tabulate_receptances(functions[RAIL], track, speed, train.axle_distances, range(-3, 3))
    midband = third_octaves.midbands(2.0, 8.0)
    on_lines = lines(tuple(midband), train, speed)
    f = on_lines.frequency

    def passage(tolerance):
        excited = excitation(train, moving, ROUGH, speed, 30.0, tolerance)
        return passage_spectra(functions, excited, train.length, speed, f)

    usual, exact = passage(1e-4), passage(1e-6)
    for receiver in functions:
        around = maximum_filter1d(exact[receiver], 17)  # a ripple's period holds eight lines at least
        assert np.all(np.abs(usual[receiver] - exact[receiver]) < 3e-4 * around)
        np.testing.assert_allclose(
            on_lines.mean_squares(usual[receiver]),
            on_lines.mean_squares(exact[receiver]),
            rtol=1e-4,
        )
