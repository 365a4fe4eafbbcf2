"""A constant load moving on an elastic half-space, slower than its Rayleigh wave: closed form and package."""

import math

import numpy as np
import pytest

from railvib.parameters.ground import Ground, Layer
from railvib.soil._kernels.layers import surface_flexibilities
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.strip import strip_compliance
from tests.consistency.reference import rows

ROWS = rows("moving_load")


def half_space(row, loss_factor):
    nu = float(row["poisson_ratio"])
    cs = float(row["shear_speed_m_s"])
    cp = cs * math.sqrt((2.0 - 2.0 * nu) / (1.0 - 2.0 * nu))
    density = float(row["density_kg_m3"])
    return Ground(
        layers=[Layer(shear_speed=cs, dilatational_speed=cp, density=density, loss_factor=loss_factor)]
    )


def closed_form(layer: Layer, x: float, y: float, speed: float) -> float:
    """Return the displacement per force at x ahead of the load and y beside its path, m/N."""
    r = math.hypot(x, y)
    s = speed * abs(y) / r
    q = (s / layer.shear_speed) ** 2
    p_root, s_root = math.sqrt(1.0 - (s / layer.dilatational_speed) ** 2), math.sqrt(1.0 - q)
    if q == 0.0:
        return (1.0 - layer.poisson_ratio) / (2.0 * math.pi * layer.shear_modulus * r)
    return -q * p_root / ((2.0 - q) ** 2 - 4.0 * p_root * s_root) / (2.0 * math.pi * layer.shear_modulus * r)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["load_speed_m_s"])
def test_closed_form_against_table(row):
    (layer,) = half_space(row, 0.0).layers
    u = closed_form(layer, 0.0, float(row["offset_m"]), float(row["load_speed_m_s"]))
    assert u == pytest.approx(float(row["displacement_m_n"]), rel=1e-5)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["load_speed_m_s"])
@pytest.mark.parametrize("x", [0.0, 3.0, -7.0])
def test_flexibility_integrated_over_the_plane(row, x):
    """Q33 at ω = −βv over both wavenumbers: polar coordinates, with e^{−aρ} of a source spread over a few
    centimetres.

    Elastic, and slower than the Rayleigh wave, so nothing is singular. For a half-space ρ Q33 depends on
    direction only, and the integral over ρ is elementary: (1/4π²) ∫ ρQ33(θ) / (a − i r cos(θ − φ)) dθ.
    """
    ground = half_space(row, 0.0)
    y, speed = float(row["offset_m"]), float(row["load_speed_m_s"])
    spread = 0.002
    count = 400_000
    theta = 2.0 * np.pi * (np.arange(count // 4) + 0.5) / count  # Q33 has the symmetry of |cos θ|
    q = np.array(
        [
            surface_flexibilities(np.array([1.0]), speed * c, ground.stack(), False)[0]
            for c in np.cos(theta[:: count // 4000])
        ]
    )
    q = np.interp(theta, theta[:: count // 4000], q.real)
    total = 0.0
    for turned in (theta, np.pi - theta, np.pi + theta, -theta):
        phase = x * np.cos(turned) + y * np.sin(turned)
        total += (q / (spread - 1j * phase)).sum().real * 2.0 * np.pi / count
    u = total / (4.0 * np.pi**2)
    assert u == pytest.approx(closed_form(ground.layers[0], x, y, speed), rel=1e-4)


@pytest.mark.parametrize("row", ROWS[1:], ids=lambda row: row["load_speed_m_s"])
def test_package(row):
    """The rational fit's closed forms at ω̂ = −βv, a strip 0.1 m wide instead of a point, integrated over
    β.

    Damping of 1e-3 stands for none: it changes the response by its square.
    """
    ground = half_space(row, 1e-3)
    y, speed = float(row["offset_m"]), float(row["load_speed_m_s"])
    fit = fit_flexibility(ground, 1.0, 1e-9, largest=2000.0)
    node, weight = np.polynomial.legendre.leggauss(12)
    edges = np.concatenate([[1e-9], np.geomspace(1e-6, 8.0, 60)])
    total = 0.0
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        for beta, w in zip(
            0.5 * (low + high) + 0.5 * (high - low) * node, 0.5 * (high - low) * weight, strict=True
        ):
            here = fit.scale(beta * speed / (2.0 * np.pi))
            compliance = strip_compliance(here, np.array([beta]), 0.05, np.array([y]))[0, 0]
            total += w * compliance.real / np.pi  # −β and β are conjugate: the imaginary parts cancel
    assert total == pytest.approx(float(row["displacement_m_n"]), rel=1e-3)
    assert total == pytest.approx(closed_form(ground.layers[0], 0.0, y, speed), rel=1e-4)
