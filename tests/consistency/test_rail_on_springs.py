"""A rail on a two-layer support without ground, against the closed form that equals rolland's to 9 digits."""

import cmath
import math

import numpy as np
import pytest

from railvib.parameters.ground import Ground, Layer
from railvib.parameters.track import Track, TrackLayer
from railvib.prediction import rail_receptance
from railvib.transfer.track_response import track_response
from tests.consistency.reference import rows

EI, RAIL_MASS, SLEEPER_MASS = 6.3777e6, 60.2, 250.0
ROCK = Ground(layers=[Layer(shear_speed=5e3, dilatational_speed=1e4, density=1e7, loss_factor=0.01)])
"""So stiff that it yields 1e-6 of what the support does."""


def viscous_track(frequency: float) -> Track:
    """Return the track whose hysteretic loss factors are, at one frequency, those of the viscous dampers."""
    omega = 2.0 * math.pi * frequency
    return Track(
        rail_bending_stiffness=EI,
        rail_mass=RAIL_MASS,
        pad_stiffness=3e8,
        pad_loss_factor=3e4 * omega / 3e8,
        sleeper_mass=SLEEPER_MASS,
        layers=[TrackLayer(stiffness=1e8, loss_factor=8e4 * omega / 1e8)],
        contact_width=2.0,
    )


def closed_form(frequency: float) -> complex:
    omega = 2.0 * math.pi * frequency
    pad, bed = 3e8 + 3e4j * omega, 1e8 + 8e4j * omega - SLEEPER_MASS * omega**2
    stiffness = pad * bed / (pad + bed) - RAIL_MASS * omega**2
    kappa = (stiffness / EI) ** 0.25
    return 1.0 / (2.0 * math.sqrt(2.0) * EI * kappa**3)


def expected(row):
    return complex(float(row["real_m_n"]), float(row["imag_m_n"]))


@pytest.mark.parametrize("row", rows("winkler_rail"), ids=lambda row: row["frequency_hz"])
class TestRailOnSprings:
    def test_integral_of_the_track_alone(self, row):
        frequency = float(row["frequency_hz"])
        edges = np.concatenate([np.linspace(0.0, 4.0, 401), np.geomspace(4.0, 400.0, 60)[1:]])
        node, weight = np.polynomial.legendre.leggauss(16)
        half = 0.5 * np.diff(edges)[:, None]
        beta = edges[:-1, None] + half * (1.0 + node)
        rail, force = track_response(viscous_track(frequency), beta, 2.0 * math.pi * frequency, 0.0)
        assert np.all(np.isfinite(force))
        sigma = (half * weight * rail).sum() / math.pi
        # Beyond 400 rad/m lies 1/(3π EI 400³) = 3e-16 m/N.
        assert abs(sigma / expected(row) - 1.0) < 1e-5
        assert abs(sigma / closed_form(frequency) - 1.0) < 1e-6

    def test_package_on_rock(self, row):
        frequency = float(row["frequency_hz"])
        sigma = rail_receptance(viscous_track(frequency), ROCK, frequency, tolerance=1e-5)
        assert abs(sigma / expected(row) - 1.0) < 1e-5

    def test_distance(self, row):
        """Away from the load the rail bends as e^{−κ|d|(1 ± i)/√2} together."""
        frequency = float(row["frequency_hz"])
        omega = 2.0 * math.pi * frequency
        pad, bed = 3e8 + 3e4j * omega, 1e8 + 8e4j * omega - SLEEPER_MASS * omega**2
        kappa = ((pad * bed / (pad + bed) - RAIL_MASS * omega**2) / EI) ** 0.25
        d = 2.0
        # Of the roots of β⁴ = −κ⁴ those with e^{iβd} decaying.
        root = [kappa * cmath.exp(1j * math.pi * (0.25 + 0.5 * n)) for n in range(4)]
        shape = sum(1j * cmath.exp(1j * b * d) / (4.0 * EI * b**3) for b in root if b.imag > 0.0)
        sigma = rail_receptance(viscous_track(frequency), ROCK, frequency, d, tolerance=1e-5)
        assert abs(sigma / shape - 1.0) < 1e-5
