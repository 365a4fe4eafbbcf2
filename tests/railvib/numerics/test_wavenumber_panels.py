"""Gauss-Legendre panels: Fourier integrals of smooth functions at any distance, against adaptive
quadrature.
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import spherical_jn

from railvib.numerics._kernels import lagrange, panels
from railvib.numerics._kernels.panels import fourier_integrals
from railvib.numerics.frequency_blocks import STENCIL
from railvib.numerics.wavenumber_panels import NODE, ORDER, nodes_between, series_tails


def test_spherical_bessel():
    x = np.array([8.0, 8.7, 11.9, 12.1, 80.0, 3000.0])
    out = np.empty((ORDER, x.size))
    panels._spherical_bessel(0.5, 2.0 * x, out)
    expected = [spherical_jn(n, x) for n in range(ORDER)]
    # Of j_n small against 1 the absolute error counts: they multiply Legendre coefficients.
    np.testing.assert_allclose(out, expected, rtol=1e-12, atol=1e-14)


def test_panel_weights_are_exact_for_polynomials():
    x = np.array([-1.0, -0.3, 0.0, 0.999, float(NODE[3])])
    weight = np.empty((ORDER, x.size))
    lagrange.panel_weights(x.size, x, weight, np.empty(x.size))
    for degree in range(ORDER):
        np.testing.assert_allclose(NODE**degree @ weight, x**degree, rtol=0.0, atol=1e-13)
    np.testing.assert_array_equal(weight[:, -1] == 0.0, np.arange(ORDER) != 3)  # on a node, that one alone


def test_stencil_weights_are_exact_for_polynomials():
    t = np.array([0.0, 3.0, 4.5, 8.999999, 9.0])
    weight = np.empty((STENCIL, t.size))
    lagrange.stencil_weights(t.size, t, weight, np.empty(t.size))
    for degree in range(STENCIL):
        np.testing.assert_allclose(
            (np.arange(STENCIL) / 9.0) ** degree @ weight, (t / 9.0) ** degree, rtol=0.0, atol=1e-12
        )


def test_fourier_integrals():
    edge = np.array([0.0, 0.5, 1.5, 4.0])
    beta = nodes_between(edge)
    distance = np.array([0.0, 0.3, 2.7, 7.0, 40.0, 900.0])

    def f(b):
        return np.exp(-b) / (1.0 + b**2)

    value = np.stack([f(beta), beta * f(beta)]).reshape(2, -1, ORDER)
    cosine, sine = np.zeros((2, distance.size)), np.zeros((2, distance.size))
    centre, half = 0.5 * (edge[1:] + edge[:-1]), 0.5 * np.diff(edge)
    fourier_integrals(centre, half, value, distance, cosine, sine)
    for k, d in enumerate(distance):
        for row, g in enumerate((f, lambda b: b * f(b))):
            for got, weight in ((cosine[row, k], "cos"), (sine[row, k], "sin")):
                expected = quad(g, 0.0, 4.0, weight=weight, wvar=d, epsabs=1e-13, limit=2000)[0]
                assert got == pytest.approx(expected, abs=3e-9)


def test_fourier_integrals_are_added():
    cosine, sine = np.full((1, 1), 5.0), np.full((1, 1), 7.0)
    fourier_integrals(np.array([1.0]), np.array([1.0]), np.ones((1, 1, ORDER)), np.array([0.0]), cosine, sine)
    assert cosine[0, 0] == pytest.approx(7.0)
    assert sine[0, 0] == pytest.approx(7.0)


def test_unresolved_panels():
    beta = nodes_between(np.array([0.0, 1.0, 2.0]))
    value = np.where(beta < 1.0, beta**5, np.abs(beta - 1.4))
    size = series_tails(value)
    assert size[0] < 1e-14
    assert size[1] > 1e-3
