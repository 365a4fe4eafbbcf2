"""Direct quadrature, the judge of the closed forms: against plain rules that share nothing with it."""

import numpy as np
import pytest
from scipy.integrate import quad

from railvib.parameters.ground import Ground, Layer
from railvib.soil.flexibility import ground_flexibility
from railvib.soil.quadrature import (
    adaptive_integral,
    strip_compliance_by_quadrature,
    strip_mean_by_quadrature,
)

B = 1.6


def test_adaptive_integral_of_peaks_and_oscillations():
    def integrand(t):
        return np.stack([1.0 / ((t - 0.3) ** 2 + 1e-8), np.cos(300.0 * t) + 1j * t, np.sqrt(t)], axis=1)

    expected = [
        (np.arctan(0.7e4) + np.arctan(0.3e4)) * 1e4,
        np.sin(300.0) / 300.0 + 0.5j,
        2.0 / 3.0,
    ]
    value = adaptive_integral(integrand, [0.0, 0.5, 1.0], 1e-10)
    np.testing.assert_allclose(value, expected, rtol=1e-9)


def test_adaptive_integral_against_scipy():
    def f(t):
        return np.exp(-t) * np.abs(np.sin(5.0 * t))

    expected, _error = quad(f, 0.0, 3.0, points=np.pi / 5.0 * np.arange(1, 5), epsabs=1e-13, limit=200)
    value = adaptive_integral(lambda t: f(t)[:, None], [0.0, 3.0], 1e-10)
    assert value[0] == pytest.approx(expected, rel=1e-9)


def test_adaptive_integral_says_when_it_does_not_converge():
    with pytest.raises(ArithmeticError, match="quadrature did not reach"):
        adaptive_integral(lambda t: 1.0 / t[:, None], [0.0, 1.0], 1e-9)


def trapezoid(ground: Ground, beta: float, y: float, frequency: float) -> complex:
    """Return C(β, y) by the trapezoidal rule, up to a γ at which the first term of the truncation error
    vanishes.
    """
    last = (np.floor(600.0 * B / np.pi) + 0.5) * np.pi / B
    gamma = np.linspace(0.0, last, 600_001)
    values = (
        ground_flexibility(ground, np.hypot(beta, gamma), frequency)
        * np.sinc(gamma * B / np.pi)
        * np.cos(gamma * y)
        / np.pi
    )
    return complex(np.trapezoid(values, gamma))


@pytest.mark.parametrize(("beta", "y"), [(0.0, 0.0), (0.3, 0.0), (1.5, 0.0), (0.2, 0.7)])
def test_strip_against_trapezoid(beta, y, greby):
    c = strip_compliance_by_quadrature(greby, B, beta, [y], 20.0)[0]
    # The rule's steps of 1e-3 rad/m resolve damped peaks fully; what is cut off at 600 rad/m is of order
    # 1/(Γb)^2 at y ≠ 0.
    assert abs(c / trapezoid(greby, beta, y, 20.0) - 1.0) < (1e-8 if y == 0.0 else 3e-6)


def test_strip_against_scipy(greby):
    def integral(part):
        def integrand(gamma):
            q = ground_flexibility(greby, np.hypot(0.4, gamma), 12.0)
            return getattr(q, part) * np.sinc(gamma * B / np.pi) / np.pi

        # Beyond 40.5π/b ~ 80 rad/m the rest is below 1e-6 of the whole.
        return quad(integrand, 0.0, 160.5 * np.pi / B, limit=2000, epsabs=1e-18)[0]

    c = strip_compliance_by_quadrature(greby, B, 0.4, [0.0], 12.0)[0]
    assert abs(c / complex(integral("real"), integral("imag")) - 1.0) < 1e-6


@pytest.mark.parametrize("beta", [0.0, 0.4, 2.0])
def test_mean_against_scipy(beta, greby):
    last = 200.0 * np.pi / B

    def integral(part):
        def integrand(gamma):
            q = ground_flexibility(greby, np.hypot(beta, gamma), 12.0)
            return getattr(q, part) * np.sinc(gamma * B / np.pi) ** 2 / np.pi

        return quad(integrand, 0.0, last, limit=2000, epsabs=1e-18)[0]

    # Beyond, the flexibility falls like 1/γ and sin²(γb) is 1/2 on average.
    rest = ground_flexibility(greby, last, 12.0) / (4.0 * np.pi * B**2 * last)
    c = strip_mean_by_quadrature(greby, B, beta, 12.0)
    assert abs(c / (complex(integral("real"), integral("imag")) + rest) - 1.0) < 1e-7


def test_strip_at_all_offsets_together(greby):
    offsets = [0.0, 1.0, B, 1.7, 8.0, 100.0]
    together = strip_compliance_by_quadrature(greby, B, 0.1, offsets, 5.0)
    alone = np.array([strip_compliance_by_quadrature(greby, B, 0.1, [y], 5.0)[0] for y in offsets])
    np.testing.assert_allclose(together, alone, rtol=1e-7)
    mirrored = strip_compliance_by_quadrature(greby, B, -0.1, [-y for y in offsets], 5.0)
    np.testing.assert_allclose(mirrored, together, rtol=1e-12)


@pytest.mark.parametrize("frequency", [0.1, 5.0, 80.0])
def test_strip_on_thin_stiff_crust_and_rigid_base(frequency):
    """Where evanescent modes lie far out: the path may not cross them. The judge is the trapezoidal rule."""
    crust = Layer(
        shear_speed=1500.0, dilatational_speed=3000.0, density=2400.0, loss_factor=0.03, thickness=0.3
    )
    soft = Layer(shear_speed=80.0, dilatational_speed=300.0, density=1700.0, loss_factor=0.1, thickness=4.0)
    for ground in (Ground(layers=[crust, soft], base="rigid"), Ground(layers=[soft, crust], base="rigid")):
        c = strip_compliance_by_quadrature(ground, B, 0.3, [0.0], frequency)[0]
        # What the rule cuts off falls like Γ^-3: 4e-7 at 80 Hz, 1e-9 with an end four times as far.
        assert abs(c / trapezoid(ground, 0.3, 0.0, frequency) - 1.0) < 1e-6
