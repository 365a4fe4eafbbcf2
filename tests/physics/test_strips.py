"""Boundary elements of the ground against quadrature, a spectral method, and finite elements with PML."""

import numpy as np
import pytest
from scipy.special import jv

from railvib.fe_be._kernels import boundary_elements as kernels
from railvib.fe_be.boundary_elements import graded_edges, receiver_flexibility, strip_flexibility
from railvib.soil.flexibility_tensor import ground_flexibility_tensor
from railvib.soil.quadrature import strip_compliance_by_quadrature
from railvib.soil.tensor_fit import fit_tensor
from tests.physics.fe_pml import Extent, GroundSection

B = 1.6
ALONG_IS_TURNED = 1j  # û_x = u_x/i and f̂_x = f_x/i


def strips(ground, edge, beta, frequency, reach=50.0):
    fit = fit_tensor(ground, frequency, largest=reach / np.diff(edge).min())
    return strip_flexibility(fit, np.array([beta]), edge)[0]


def receivers(ground, edge, beta, frequency, offset):
    fit = fit_tensor(ground, frequency, 1e-10, largest=50.0 / np.diff(edge).min())
    return receiver_flexibility(fit, np.array([beta]), edge, np.asarray(offset, float))[0]


def turned(matrix):
    """Return flexibilities of û_x, f̂_x as those of u_x, f_x."""
    n = matrix.shape[1] // 3
    columns = np.concatenate([np.full(n, 1.0 / ALONG_IS_TURNED), np.ones(2 * n)])
    rows = 1.0 / columns if matrix.shape[0] == 3 * n else np.ones(matrix.shape[0])
    return rows[:, None] * matrix * columns


def wavenumbers(ground, frequency, last):
    """Return Gauss nodes and weights over γ from 0 to `last`, fine where waves travel."""
    top = 2.0 * np.pi * frequency / ground.slowest_speed
    edges = np.concatenate(
        [np.linspace(0.0, 2.0 * top + 0.5, 300), np.arange(2.0 * top + 0.5, last, 0.5)[1:]]
    )
    node, weight = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(edges)[:, None]
    return ((edges[:-1, None] + half) + half * node).ravel(), (half * weight).ravel()


def strips_by_quadrature(ground, edge, beta, frequency, last=6000.0):
    """Return the strips' flexibility from the inverse transform of the tensor, along the real axis."""
    gamma, weight = wavenumbers(ground, frequency, last)
    tensor = ground_flexibility_tensor(ground, beta, gamma, frequency)
    low, high = edge[:-1, None], edge[1:, None]
    even = (np.sin(gamma * high) - np.sin(gamma * low)) / gamma / (high - low)
    odd = (np.cos(gamma * low) - np.cos(gamma * high)) / gamma / (high - low)
    # Transforms of a unit force on a strip and its image, and averages of a field over the strip.
    load = [2.0 * even, -2j * odd, 2.0 * even]
    mean = [even, 1j * odd, even]
    return np.block(
        [[(mean[i] * weight * tensor[:, i, j]) @ load[j].T / np.pi for j in range(3)] for i in range(3)]
    )


@pytest.mark.parametrize(("beta", "frequency"), [(0.0, 20.0), (1e-3, 5.0), (0.9, 20.0), (4.0, 80.0)])
def test_strips_equal_quadrature(greby, beta, frequency):
    edge = np.array([0.0, 0.3, 1.0, B])
    judged = strips_by_quadrature(greby, edge, beta, frequency)
    found = turned(strips(greby, edge, beta, frequency, 1000.0))
    # What the judge cuts off beyond 6000 rad/m is 1e-6 of the terms under the load.
    np.testing.assert_allclose(found, judged, rtol=0.0, atol=2e-6 * abs(judged).max())
    np.testing.assert_allclose(found[:3, 3:6], judged[:3, 3:6], rtol=0.0, atol=1e-8 * abs(judged).max())
    np.testing.assert_allclose(found[6:, :6], judged[6:, :6], rtol=0.0, atol=1e-8 * abs(judged).max())


def test_matrix_is_symmetric(greby):
    matrix = strips(greby, graded_edges(B, 6), 0.7, 30.0)
    np.testing.assert_allclose(matrix, matrix.T, rtol=0.0, atol=1e-12 * abs(matrix).max())


@pytest.mark.parametrize("beta", [0.0, 0.2, 1.2])
def test_flexible_strip_under_uniform_load(greby, beta):
    """One strip is the uniform load whose compliance the adaptive quadrature knows."""
    offsets = [0.0, 0.7, 8.0, 32.0]
    found = receivers(greby, np.array([0.0, B]), beta, 20.0, offsets)[:, 2] / 2.0
    judged = strip_compliance_by_quadrature(greby, B, beta, offsets, 20.0)
    np.testing.assert_allclose(found, judged, rtol=1e-6, atol=1e-8 * abs(judged[0]))


@pytest.mark.parametrize("offset", [0.4, 6.0])
def test_receivers_and_strips_are_reciprocal(greby, offset):
    """A narrow strip at the receiver moves under forces on others as the receiver does."""
    edge = np.array([0.0, offset - 0.3, offset - 1e-3, offset + 1e-3])
    matrix = strips(greby, edge, 0.5, 20.0)
    rows = receivers(greby, edge, 0.5, 20.0, [offset])[0]
    for axis in range(3):
        assert abs(matrix[8, 3 * axis] / rows[3 * axis] - 1.0) < 1e-5


def rigid_by_chebyshev(tensor, gamma, weight, half_width, static, terms=7):
    """Return the compliance of a rigid smooth strip: tractions T_2m(y/b)/√(b² − y²), whose transforms are
    Bessel functions; beyond the last γ the static flexibility `static`/γ with the mean of J² in closed form.
    """
    bessel = np.array([jv(2 * m, gamma * half_width) for m in range(terms)])
    matrix = (bessel * (tensor * weight)) @ bessel.T / np.pi
    sign = (-1.0) ** np.arange(terms)
    matrix = matrix + np.outer(sign, sign) * static / (np.pi**2 * half_width * gamma[-1])
    return 1.0 / np.linalg.solve(matrix, np.eye(terms)[0])[0]


def rigid_strip(ground, beta, frequency):
    gamma, weight = wavenumbers(ground, frequency, 3000.0)
    tensor = ground_flexibility_tensor(ground, beta, gamma, frequency)[:, 2, 2]
    (top, *_rest) = ground.layers
    static = (1.0 - top.poisson_ratio) / top.shear_modulus / (1.0 + 1j * top.loss_factor)
    return rigid_by_chebyshev(tensor, gamma, weight, B, static)


def rigid_by_strips(ground, edge, beta, frequency):
    n = edge.size - 1
    vertical = strips(ground, edge, beta, frequency)[2 * n :, 2 * n :]
    return 1.0 / (2.0 * np.linalg.solve(vertical, np.ones(n)).sum())


def test_judge_of_rigid_strip_knows_the_closed_form():
    """At rest, w/F = (1 − ν)/(πμ) [ln(4/(βb)) − γ] for βb ≪ 1, from p = F/(π√(b² − y²))."""
    beta = 1e-3 / B
    edges = np.concatenate([[0.0], np.geomspace(beta / 50.0, 1.0, 80), np.arange(1.5, 2000.0, 0.5)])
    node, share = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(edges)[:, None]
    gamma, weight = (edges[:-1, None] + half * (1.0 + node)).ravel(), (half * share).ravel()
    found = rigid_by_chebyshev(1.0 / np.hypot(beta, gamma), gamma, weight, B, 1.0)
    closed = (np.log(4.0 / (beta * B)) - np.euler_gamma) / np.pi
    assert abs(found / closed - 1.0) < 1e-6


@pytest.mark.parametrize(("beta", "frequency"), [(0.0, 20.0), (3.0, 20.0), (1.0, 60.0)])
def test_rigid_strip_converges_at_the_rate_of_its_grading(greby, horstwalde, beta, frequency):
    """Tractions like 1/√distance on n strips that shrink like the power 2.5: errors fall like n^−2.5."""
    for ground in (greby, horstwalde):
        judged = rigid_strip(ground, beta, frequency)
        error = [
            abs(rigid_by_strips(ground, graded_edges(B, n), beta, frequency) / judged - 1.0)
            for n in (4, 8, 16)
        ]
        assert error[1] < 1.2e-3
        rate = np.log2(error[0] / error[2]) / 2.0
        assert 2.2 < rate < 3.2


def test_equal_strips_converge_like_their_width(greby):
    judged = rigid_strip(greby, 0.5, 20.0)
    error = [
        abs(rigid_by_strips(greby, np.linspace(0.0, B, n + 1), 0.5, 20.0) / judged - 1.0) for n in (4, 8, 16)
    ]
    assert 0.9 < np.log2(error[0] / error[2]) / 2.0 < 1.2


def test_truncation_in_wavenumber(greby):
    """What the fit's range leaves out: its error falls like 1/range², and is below 1e-5 where it is set."""
    edge = graded_edges(B, 8)
    n = edge.size - 1

    def compliance(reach):
        vertical = strips(greby, edge, 0.5, 20.0, reach)[2 * n :, 2 * n :]
        return 1.0 / (2.0 * np.linalg.solve(vertical, np.ones(n)).sum())

    far = compliance(1000.0)
    error = [abs(compliance(reach) / far - 1.0) for reach in (12.5, 50.0)]
    assert error[1] < 1e-5
    assert error[1] < 0.3 * error[0]


@pytest.mark.parametrize(("beta", "frequency"), [(0.5, 20.0), (1.2, 20.0), (0.3, 8.0)])
def test_soil_equals_finite_elements_with_pml(greby, beta, frequency):
    edge = np.array([0.0, 0.5, 1.0, B])
    section = GroundSection(greby, edge, beta, frequency, Extent(5.0, 5.0, 8.0, 0.5))
    judged, field = section.strips(np.array([5.0]))
    found = turned(strips(greby, edge, beta, frequency))
    np.testing.assert_allclose(found, judged, rtol=0.0, atol=0.01 * abs(judged).max())
    found = turned(receivers(greby, edge, beta, frequency, [5.0]))
    np.testing.assert_allclose(found, field, rtol=0.0, atol=0.01 * abs(field).max())


def test_compiled_equals_plain(greby):
    fit = fit_tensor(greby, 20.0, 1e-4)
    edge, beta = np.array([0.0, 1.0, B]), np.array([0.0, 2.0])
    arguments = (beta, fit.pole, fit.residue, fit.constant, edge)
    compiled = kernels.strip_flexibility(*arguments)
    np.testing.assert_allclose(
        kernels.strip_flexibility.py_func(*arguments), compiled, rtol=0.0, atol=1e-12 * abs(compiled).max()
    )
    offset = np.array([0.5, 4.0])
    compiled = kernels.receiver_flexibility(*arguments, offset)
    np.testing.assert_allclose(
        kernels.receiver_flexibility.py_func(*arguments, offset),
        compiled,
        rtol=0.0,
        atol=1e-12 * abs(compiled).max(),
    )
