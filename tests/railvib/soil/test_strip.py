"""Closed forms of the strip: pole by pole against plain quadrature, compiled and as plain Python."""

import numpy as np
import pytest

from benchmarks.limit.operations import count_operations
from benchmarks.sections.transfer import wavenumbers
from railvib import library
from railvib.soil._kernels.strip import CLIP, NEGLIGIBLE, STRETCH, strip_compliances, strip_means
from railvib.soil.quadrature import strip_mean_by_quadrature
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.strip import mean_fit_reach, strip_compliance, strip_mean

B = 1.6
OFFSETS = np.array([0.0, 0.9, B, 8.0, 100.0])
SHARES = np.array([1.0, 1.0, 0.5, 0.0, 0.0])  # of the strip's load, at its edge the mean of both sides


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


def test_constant_acts_inside_the_strip():
    none = np.empty(0, complex)
    real, imag = strip_compliances(np.array([0.1]), none, none, 3.0 - 2.0j, B, OFFSETS)
    np.testing.assert_allclose((real + 1j * imag)[:, 0], (3.0 - 2.0j) * SHARES / (2.0 * B))


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


REACHES = np.array([0.0, 0.9, B, 1.7, 8.0, 32.0, 100.0, 300.0])


def all_terms(beta, pole, residue, constant, offsets):
    """The sum over all poles in the longest floating-point numbers, its largest term, and what rounding
    their exponents makes of it, as doubles are 2.2e-16 apart.
    """
    long = np.clongdouble
    # β² − z is rounded as in the kernel: close to a pole the field hangs on it.
    w = ((beta * beta)[:, None] - pole).astype(long)
    k, before = np.sqrt(w), residue.astype(long) / (4 * long(B) * w)
    value, largest, rounding = [], [], []
    for y in offsets.astype(np.longdouble):
        if y >= B:
            terms = before * np.exp(-k * (y - B)) * (1 - np.exp(-2 * k * B))
        else:
            terms = before * (2 - np.exp(-k * (B + y)) - np.exp(-k * (B - y)))
        share = 1.0 if y < B else 0.5 if y == B else 0.0
        value.append(terms.sum(axis=1) + share * long(constant) / (2 * B))
        largest.append(np.abs(terms).max(axis=1))
        rounding.append(4e-16 * y * np.abs(k * terms).max(axis=1))
    return np.array(value), np.array(largest), np.array(rounding)


def assert_is_the_sum_of_all_terms(beta, pole, residue, constant):
    real, imag = strip_compliances(beta, pole, residue, constant, B, REACHES)
    value, largest, rounding = all_terms(beta, pole, residue, constant, REACHES)
    left = largest > 2.0 ** (NEGLIGIBLE - CLIP) * largest[REACHES == B]
    error = np.abs(real + 1j * imag - value)
    assert np.all(error[left] <= (1e-13 * largest + rounding)[left])


@pytest.mark.parametrize("soil", ["greby", "horstwalde"])
@pytest.mark.parametrize("frequency", [1.0, 10.0, 100.0])
def test_waves_passed_over_are_nothing(soil, frequency, track):
    ground = library.load("soil", soil)
    fit = fit_flexibility(ground, frequency, 1e-10)
    beta = wavenumbers(ground, track, frequency, 200)
    assert_is_the_sum_of_all_terms(beta, fit.pole, fit.residue, fit.constant)


def test_weak_slow_poles_are_not_lost_and_hide_none():
    """Poles that decay slowly take over far away, however weak, and close by they hide no strong one."""
    pole = np.array([4.0 - 0.4j, -1.0 + 0.2j, -50.0 + 3.0j, 3.9 - 1e-4j, -1e-4 - 1e-5j, 4.1 - 1e-3j])
    residue = np.array([1.0 + 0.5j, 3.0 - 1.0j, 40.0j, 1e-12 + 0j, 1e-9j, -1e-30j])
    assert_is_the_sum_of_all_terms(np.linspace(0.0, 12.0, 75), pole, residue, 0.1 - 0.2j)


def test_waves_that_have_died_out_cost_nothing(greby):
    fit = fit_flexibility(greby, 40.0, 1e-10)
    beta = np.linspace(0.1, 4.0, 5)
    near, far, twice = (
        count_operations(
            strip_compliances, (beta, fit.pole, fit.residue, fit.constant, B, offsets), STRETCH=1
        )[1].total
        for offsets in (np.array([2.0]), np.array([100.0]), np.array([2.0, 100.0]))
    )
    assert twice - near < 0.5 * (twice - far)


def test_a_value_depends_on_its_own_wavenumber_and_offset_only(greby, track):
    fit = fit_flexibility(greby, 30.0, 1e-10)
    beta = wavenumbers(greby, track, 30.0, 3 * STRETCH + 5)

    def values(rows, columns):
        found = strip_compliances(beta[columns], fit.pole, fit.residue, fit.constant, B, REACHES[rows])
        return np.array(found)

    rng = np.random.default_rng(3)
    whole = values(slice(None), slice(None))
    rows, columns = rng.permutation(REACHES.size), rng.permutation(beta.size)
    np.testing.assert_array_equal(values(rows, columns), whole[:, rows[:, None], columns])
    for row in range(REACHES.size):
        np.testing.assert_array_equal(values([row], slice(7, 50)), whole[:, [row], 7:50])


def mean_by_trapezoid(beta, pole, residue):
    gamma = np.linspace(0.0, 400.0, 400_001)
    values = residue / (beta**2 + gamma**2 - pole) * np.sinc(gamma * B / np.pi) ** 2
    return np.trapezoid(values, gamma) / np.pi


@pytest.mark.parametrize("pole", [0.5 - 0.1j, -3.0 + 0.5j, 0.02 - 0.02j])
def test_mean_of_one_pole(pole):
    beta = np.array([0.0, 0.4, 2.0])
    real, imag = strip_means(beta, np.array([pole]), np.array([2.0 - 1.0j]), 3.0 - 2.0j, B)
    expected = [mean_by_trapezoid(b, pole, 2.0 - 1.0j) + (3.0 - 2.0j) / (2.0 * B) for b in beta]
    np.testing.assert_allclose(real + 1j * imag, expected, rtol=1e-8)


def test_mean_is_that_over_the_offsets(greby):
    """Gauss points over |y| < b; C(β, y) has infinite slope at the edge, which limits them to 1e-6."""
    fit = fit_flexibility(greby, 20.0, 1e-10)
    beta = np.array([0.0, 0.5, 1.5])
    node, weight = np.polynomial.legendre.leggauss(200)
    offset = np.sort(0.5 * B * (node + 1.0))
    expected = 0.5 * weight @ strip_compliance(fit, beta, B, offset)
    np.testing.assert_allclose(strip_mean(fit, beta, B), expected, rtol=1e-6)


def test_compiled_mean_equals_plain():
    rng = np.random.default_rng(2)
    pole = rng.normal(size=6) + 1j * rng.normal(size=6) - 0.5
    residue = rng.normal(size=6) + 1j * rng.normal(size=6)
    beta = np.linspace(0.0, 30.0, STRETCH + 7)
    compiled = strip_means(beta, pole, residue, 0.1 - 0.2j, B)
    plain = strip_means.py_func(beta, pole, residue, 0.1 - 0.2j, B)
    for one, other in zip(compiled, plain, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("argument", [1e-8, 1e-4, 1e-2, 0.0999, 0.1001, 1.0])
def test_small_arguments_of_the_mean_lose_no_digits(argument):
    """2κb below and above the place where the series takes over, against a longer one in long numbers."""
    pole = -((argument * np.exp(-0.7j) / (2.0 * B)) ** 2)
    real, imag = strip_means(np.array([0.0]), np.array([pole]), np.array([1.0 + 0j]), 0j, B)
    kappa = np.sqrt(np.clongdouble(-pole))
    # (x − 1 + e^{−x})/x = x/2 − x²/6 + …, over 2bκ²
    x = 2.0 * B * kappa
    share = np.cumprod([x / 2.0, *(-x / n for n in range(3, 30))]).sum()
    expected = complex(share / (2.0 * B * kappa**2))
    assert abs(complex(real[0], imag[0]) / expected - 1.0) < 1e-12


@pytest.mark.parametrize("frequency", [0.5, 20.0, 200.0])
@pytest.mark.parametrize("half_width", [0.1, B, 10.0])
def test_mean_against_quadrature(frequency, half_width, greby):
    """1e-7 is what lies beyond `mean_fit_reach`."""
    fit = fit_flexibility(greby, frequency, 1e-10, largest=mean_fit_reach(half_width))
    beta = 2.0 * np.pi * frequency / greby.slowest_speed * np.array([0.0, 0.7, 1.2, 3.0])
    expected = [strip_mean_by_quadrature(greby, half_width, b, frequency) for b in beta]
    np.testing.assert_allclose(strip_mean(fit, beta, half_width), expected, rtol=1e-7)
