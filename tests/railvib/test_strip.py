"""Closed forms of the strip: pole by pole against plain quadrature, compiled and as plain Python."""

import numpy as np
import pytest

from railvib.strip import strip_compliances

B = 1.6
OFFSETS = np.array([0.0, 0.9, B, 8.0, 100.0])


def by_trapezoid(beta, pole, residue, y):
    gamma = np.linspace(0.0, 400.0, 400_001)
    values = residue / (beta**2 + gamma**2 - pole) * np.sinc(gamma * B / np.pi) * np.cos(gamma * y)
    return np.trapezoid(values, gamma) / np.pi


@pytest.mark.parametrize("pole", [0.5 - 0.1j, -3.0 + 0.5j, 0.02 - 0.02j])
def test_one_pole(pole):
    beta = np.array([0.0, 0.4, 2.0])
    real, imag = strip_compliances(beta, np.array([pole]), np.array([2.0 - 1.0j]), 0j, B, OFFSETS[:4])
    for i, b in enumerate(beta):
        for j, y in enumerate(OFFSETS[:4]):
            expected = by_trapezoid(b, pole, 2.0 - 1.0j, y)
            # Beyond 400 rad/m lies 1e-8 of the integral.
            assert real[j, i] + 1j * imag[j, i] == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_constant_acts_inside_the_strip_only():
    none = np.empty(0, complex)
    real, imag = strip_compliances(np.array([0.1]), none, none, 3.0 - 2.0j, B, OFFSETS)
    np.testing.assert_allclose((real + 1j * imag)[:, 0], np.where(OFFSETS < B, (3.0 - 2.0j) / (2.0 * B), 0.0))


def test_compiled_equals_plain():
    rng = np.random.default_rng(1)
    pole = rng.normal(size=6) + 1j * rng.normal(size=6) - 0.5
    residue = rng.normal(size=6) + 1j * rng.normal(size=6)
    beta = np.linspace(0.0, 30.0, 9)
    compiled = strip_compliances(beta, pole, residue, 0.1 - 0.2j, B, OFFSETS)
    plain = strip_compliances.py_func(beta, pole, residue, 0.1 - 0.2j, B, OFFSETS)
    for one, other in zip(compiled, plain, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-14)


def test_continuous_across_the_edge_of_the_strip():
    pole, residue = np.array([0.5 - 0.1j, -4.0 + 0j]), np.array([1.0 + 0j, -0.3j])
    near = B * np.array([1.0 - 1e-9, 1.0 + 1e-9])
    real, imag = strip_compliances(np.array([0.3]), pole, residue, 0j, B, near)
    np.testing.assert_allclose(real[0], real[1], rtol=1e-7)
    np.testing.assert_allclose(imag[0], imag[1], rtol=1e-7)


def test_small_arguments_lose_no_digits():
    """For κb → 0 the closed form subtracts equals; a stray digit there would show at the lowest
    frequencies.
    """
    pole, residue = np.array([-(1e-4**2) + 0j]), np.array([1.0 + 0j])
    real, _imag = strip_compliances(np.array([0.0]), pole, residue, 0j, B, np.array([0.0, 8.0]))
    kappa = 1e-4
    series = [
        1.0 / (2.0 * kappa) - B / 4.0 + kappa * B**2 / 12.0,
        np.exp(-kappa * 8.0) * np.sinh(kappa * B) / (2.0 * kappa**2 * B),
    ]
    np.testing.assert_allclose(real[:, 0], series, rtol=1e-9)
