"""Strip and point loads on the ground: shapes, limits and what is refused."""

import math

import numpy as np
import pytest

from railvib import library
from railvib.errors import InputError
from railvib.parameters.ground import Ground, Layer
from railvib.soil.compliance import ground_green_function, line_compliance
from railvib.soil.quadrature import strip_compliance_by_quadrature
from railvib.soil.rational_fit import RationalFit, fit_flexibility

SOFT = Ground(layers=[Layer(shear_speed=150.0, dilatational_speed=400.0, density=1800.0, loss_factor=0.1)])


def test_shapes_and_symmetry():
    beta, y = np.linspace(-0.5, 0.5, 5), np.array([[0.0], [8.0], [-8.0]])
    c = line_compliance(SOFT, 1.6, beta, y, 10.0)
    assert c.shape == (3, 5)
    np.testing.assert_allclose(c, c[:, ::-1], rtol=1e-12)
    np.testing.assert_allclose(c[1], c[2], rtol=1e-14)
    assert line_compliance(SOFT, 1.6, 0.1, 8.0, 10.0) == pytest.approx(
        line_compliance(SOFT, 1.6, 0.1, 8.0, [10.0, 20.0])[0]
    )


def test_point_load_close_by_is_static():
    """u → (1 − ν)F/(2πμr) as r → 0 (Boussinesq)."""
    (layer,) = SOFT.layers
    r = 1e-3
    modulus = layer.shear_modulus * (1.0 + 0.1j)
    expected = (1.0 - layer.poisson_ratio) / (2.0 * math.pi * modulus * r)
    assert abs(ground_green_function(SOFT, r, 5.0) / expected - 1.0) < 1e-3


def test_point_loads_along_a_line_make_a_line_load():
    """The Green's function summed over a line of points, e^{−iβx}, is the compliance of a narrow strip."""
    beta, y, f = 0.15, 6.0, 12.0
    x = np.linspace(-450.0, 450.0, 7201)
    u = ground_green_function(SOFT, np.hypot(x, y), f)
    total = np.trapezoid(u * np.cos(beta * x), x)
    assert abs(total / line_compliance(SOFT, 0.01, beta, y, f) - 1.0) < 1e-4


def test_falls_back_to_quadrature(monkeypatch):
    monkeypatch.setattr(
        "railvib.soil.compliance._fit",
        lambda *_arguments, **_options: RationalFit(
            np.array([1j]), np.array([1.0 + 0j]), 0j, 1.0, np.array([0.0])
        ),
    )
    c = line_compliance(SOFT, 1.6, [0.1, 0.3], 8.0, 10.0)
    expected = [strip_compliance_by_quadrature(SOFT, 1.6, b, [8.0], 10.0)[0] for b in (0.1, 0.3)]
    np.testing.assert_allclose(c, expected, rtol=1e-8)
    with pytest.raises(ArithmeticError, match="fitted to"):
        ground_green_function(SOFT, 8.0, 10.0)


@pytest.mark.parametrize(
    ("half_width", "frequency", "name"),
    [
        (0.0, 10.0, "half_width"),
        (-1.0, 10.0, "half_width"),
        (1.6, 0.0, "frequency"),
        (1.6, -3.0, "frequency"),
        (1.6, np.nan, "frequency"),
        (1.6, np.inf, "frequency"),
    ],
)
def test_refused(half_width, frequency, name):
    with pytest.raises(InputError, match=rf"{name} = "):
        line_compliance(SOFT, half_width, 0.1, 8.0, frequency)


@pytest.mark.parametrize(("distance", "frequency"), [(0.0, 10.0), (-1.0, 10.0), (np.nan, 10.0), (8.0, 0.0)])
def test_refused_green_function(distance, frequency):
    with pytest.raises(InputError, match=" = "):
        ground_green_function(SOFT, distance, frequency)


@pytest.mark.parametrize(("soil", "frequency"), [("greby", 20.0), ("greby", 100.0), ("horstwalde", 5.0)])
def test_at_the_edge_of_the_strip(soil, frequency):
    ground, b = library.load("soil", soil), 1.6
    for beta in (0.1, 0.5):
        expected = strip_compliance_by_quadrature(ground, b, beta, [b], frequency)[0]
        assert line_compliance(ground, b, beta, b, frequency) == pytest.approx(expected, rel=1e-8)


def test_calls_for_one_ground_and_frequency_share_a_fit(monkeypatch):
    fits = []

    def fit(*arguments, **options):
        fits.append(arguments)
        return fit_flexibility(*arguments, **options)

    monkeypatch.setattr("railvib.soil.compliance.fit_flexibility", fit)
    for offset in (0.0, 8.0, 32.0, 100.0):
        line_compliance(SOFT, 1.6, 0.1, offset, 17.3)
    assert len(fits) == 1


@pytest.mark.parametrize("loss_factor", [0.0, 1e-6])
def test_without_damping(loss_factor):
    ground = Ground(layers=[SOFT.layers[0].model_copy(update={"loss_factor": loss_factor})])
    with pytest.raises(InputError, match=r"layers\[0\].loss_factor"):
        line_compliance(ground, 1.6, 0.1, 8.0, 10.0)
    with pytest.raises(InputError, match=r"layers\[0\].loss_factor"):
        ground_green_function(ground, 8.0, 10.0)
