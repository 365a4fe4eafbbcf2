"""The unevenness: each form restated over cycles per metre, variances, ranges of validity and refusals."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from railvib.errors import InputError
from railvib.levels import references
from railvib.numerics import third_octaves
from railvib.parameters.unevenness import Unevenness

HAMID_YANG = {1: 15.53e-8, 2: 8.85e-8, 3: 4.92e-8, 4: 2.75e-8, 5: 1.57e-8, 6: 0.98e-8}
AV = {1: 1.2107, 2: 1.0181, 3: 0.6816, 4: 0.5376, 5: 0.2095, 6: 0.0339}  # cm²·rad/m

# S(n) in m²/(cycle/m), n in cycles/m, written anew from the sources in their own units.
RESTATED = [
    *(
        (
            {"form": "fra-hamid-yang", "line_class": c},
            lambda n, a=a: a / n**4 * (n**2 + 0.0233**2) / (1 + (n / 0.131) ** 2),
        )
        for c, a in HAMID_YANG.items()
    ),
    *(
        (
            {"form": "fra-av", "line_class": c},
            lambda n, a=a: (
                2 * np.pi * 1e-4 * 0.25 * a / (2 * np.pi * n) ** 2 / (1 + (2 * np.pi * n / 0.8245) ** 2)
            ),
        )
        for c, a in AV.items()
    ),
    *(
        (
            {"form": f"german-{name}"},
            lambda n, a=a: (
                2 * np.pi * a / ((2 * np.pi * n) ** 2 + 0.0206**2) / (1 + (2 * np.pi * n / 0.8246) ** 2)
            ),
        )
        for name, a in (("low", 4.032e-7), ("high", 1.08e-6))
    ),
    ({"form": "sncf-good"}, lambda n: 308e-6 * 0.509 / (1 + n / 0.0489) ** 3),
    ({"form": "sncf-poor"}, lambda n: 308e-6 * 1.79 / (1 + n / 0.0489) ** 3),
    ({"form": "power-law", "amplitude": 2e-9, "exponent": 3.2}, lambda n: 2e-9 / n**3.2),
]


@pytest.mark.parametrize(
    ("parameters", "restated"), RESTATED, ids=lambda p: str(p) if isinstance(p, dict) else ""
)
def test_restated_over_cycles_per_metre(parameters, restated):
    n = np.geomspace(1e-3, 1e2, 41)
    np.testing.assert_allclose(
        Unevenness(**parameters).psd(2 * np.pi * n), restated(n) / (2 * np.pi), rtol=1e-12
    )


@pytest.mark.parametrize(
    ("parameters", "restated"), RESTATED, ids=lambda p: str(p) if isinstance(p, dict) else ""
)
def test_variance_of_a_band_is_the_integral_in_either_unit(parameters, restated):
    unevenness = Unevenness(**parameters)
    for low, high in ((0.01, 0.02), (0.003, 5.0), (10.0, 12.0)):  # cycles/m
        expected, _ = quad(
            lambda x: restated(np.exp(x)) * np.exp(x), np.log(low), np.log(high), epsrel=1e-12, epsabs=0
        )
        assert unevenness.band_mean_square(2 * np.pi * low, 2 * np.pi * high) == pytest.approx(
            expected, rel=1e-11
        )


def test_closed_form_variance_of_hamid_and_yang():
    # Partial fractions of A n2² (x + n1²) / (x² (x + n2²)), x = n².
    n1, n2, a = 0.0233, 0.131, 4.92e-8
    simple = (n2**2 - n1**2) / n2**4

    def primitive(n):
        return a * n2**2 * (-simple / n - (n1 / n2) ** 2 / (3 * n**3) - simple / n2 * math.atan(n / n2))

    variance = Unevenness(form="fra-hamid-yang", line_class=3).band_mean_square(
        2 * np.pi * 0.02, 2 * np.pi * 0.4
    )
    assert variance == pytest.approx(primitive(0.4) - primitive(0.02), rel=1e-12)


def test_closed_form_variance_of_a_power_law():
    unevenness = Unevenness(form="power-law", amplitude=1e-8, exponent=3.0)
    lower, upper = np.array([0.1, 1.0]), np.array([0.2, 50.0])
    n = lower / (2 * np.pi), upper / (2 * np.pi)
    np.testing.assert_allclose(
        unevenness.band_mean_square(lower, upper), 1e-8 / 2 * (n[0] ** -2 - n[1] ** -2), rtol=1e-12
    )


def test_variances_add():
    unevenness = Unevenness(form="german-low", minimum_wavelength=0.5, maximum_wavelength=70.0)
    limits = np.geomspace(0.01, 100.0, 37)
    whole = unevenness.band_mean_square(0.01, 100.0)
    assert unevenness.band_mean_square(limits[:-1], limits[1:]).sum() == pytest.approx(whole, rel=1e-12)


def test_the_two_fra_forms_are_not_interchangeable():
    beta = 2 * np.pi / 10.0
    ratio = [
        Unevenness(form="fra-av", line_class=c).psd(beta)
        / Unevenness(form="fra-hamid-yang", line_class=c).psd(beta)
        for c in range(1, 7)
    ]
    np.testing.assert_array_equal(np.round(ratio), [29, 43, 52, 74, 50, 13])


def test_classes_grow_smoother():
    for form in ("fra-hamid-yang", "fra-av"):
        density = [float(Unevenness(form=form, line_class=c).psd(1.0)) for c in range(1, 7)]
        assert density == sorted(density, reverse=True)


def test_cut_offs():
    free = Unevenness(form="fra-hamid-yang", line_class=3)
    cut = Unevenness(form="fra-hamid-yang", line_class=3, minimum_wavelength=2.0, maximum_wavelength=40.0)
    beta = 2 * np.pi / np.array([100.0, 41.0, 39.0, 10.0, 2.1, 1.9, 0.1])
    inside = np.array([False, False, True, True, True, False, False])
    np.testing.assert_array_equal(cut.psd(beta), np.where(inside, free.psd(beta), 0.0))
    assert cut.band_mean_square(0.01, 100.0) == free.band_mean_square(2 * np.pi / 40.0, 2 * np.pi / 2.0)
    assert cut.band_mean_square(10.0, 20.0) == 0.0


def test_extrapolated_share():
    unevenness = Unevenness(form="fra-hamid-yang", line_class=3)
    shortest = 2 * np.pi / 1.524
    assert unevenness.validity == (1.524, 304.8)
    np.testing.assert_array_equal(
        unevenness.extrapolated_share([0.5, shortest * 1.1, 0.001], [1.0, shortest * 2, 0.002]),
        [0.0, 1.0, 1.0],
    )
    across = unevenness.extrapolated_share(shortest / 2, shortest * 2)
    whole = unevenness.band_mean_square(shortest / 2, shortest * 2)
    assert across == pytest.approx(unevenness.band_mean_square(shortest, shortest * 2) / whole, rel=1e-12)


def test_cut_offs_leave_nothing_to_extrapolate():
    unevenness = Unevenness(form="sncf-good", minimum_wavelength=2.0, maximum_wavelength=40.0)
    np.testing.assert_array_equal(unevenness.extrapolated_share([0.001, 1.0, 10.0], [100.0, 2.0, 20.0]), 0.0)


def test_a_power_law_is_stated_everywhere():
    unevenness = Unevenness(form="power-law", amplitude=1e-8, exponent=3.0)
    assert unevenness.validity == (0.0, math.inf)
    assert unevenness.extrapolated_share(1e-3, 1e3) == 0.0


def test_table_of_a_power_law_is_the_power_law():
    law = Unevenness(form="power-law", amplitude=3e-8, exponent=2.7)
    wavelength = (50.0, 8.0, 3.0, 0.7)
    table = Unevenness(
        form="table",
        wavelength=wavelength,
        spectral_density=tuple(float(law.psd(2 * np.pi / w)) for w in wavelength),
    )
    beta = np.geomspace(0.01, 100.0, 50)
    np.testing.assert_allclose(table.psd(beta), law.psd(beta), rtol=1e-12)
    lower, upper = 2 * np.pi / 60.0, 2 * np.pi / 0.5
    assert table.band_mean_square(lower, upper) == pytest.approx(
        float(law.band_mean_square(lower, upper)), rel=1e-12
    )
    assert table.validity == (0.7, 50.0)
    assert table.extrapolated_share(lower, 2 * np.pi / 51.0) == 1.0


def test_table_with_kinks_is_integrated_exactly():
    beta = np.array([0.1, 1.0, 2.0, 30.0])
    density = np.array([1e-4, 1e-7, 5e-7, 1e-10])
    table = Unevenness(
        form="table", wavelength=tuple((2 * np.pi / beta).tolist()), spectral_density=tuple(density.tolist())
    )
    slope = np.diff(np.log(density)) / np.diff(np.log(beta))
    exact = np.diff(density * beta) / (1 + slope)  # of each power law between two points
    assert table.band_mean_square(0.1, 30.0) == pytest.approx(exact.sum(), rel=1e-11)


@pytest.mark.parametrize("slope", [-3.0, -1.0, 0.0, 40.0, -49.0, 700.0, -1e4, 1e5])
def test_steep_tables_are_integrated_exactly(slope):
    """A table that rises or falls by a power of β between its middle points, by long arithmetic."""
    beta = np.array([0.5, 1.0, 1.0 + 30.0 / max(abs(slope), 30.0), 8.0])
    density = np.array([1e-7, 1e-7, 1e-7 * (beta[2] / beta[1]) ** slope, 0.0])
    density[3] = density[2]
    table = Unevenness(
        form="table", wavelength=tuple((2 * np.pi / beta).tolist()), spectral_density=tuple(density.tolist())
    )
    # The rounding of 2π/λ moves the points by some 1e-16, which a steep slope makes a change of S.
    knots = 2.0 * np.pi / np.array(table.wavelength)
    x, y = np.log(knots.astype(np.longdouble)), np.log(density.astype(np.longdouble))
    power = 1 + np.diff(y) / np.diff(x)
    start, stop = np.exp(x + y)[:-1], np.exp(x + y)[1:]
    exact = np.where(
        np.abs(power) > 1e-9, (stop - start) / np.where(power == 0, 1, power), start * np.diff(x)
    )
    for low, high in ((0, 3), (1, 2), (0, 1)):
        result = table.band_mean_square(knots[low], knots[high])
        assert float(result) == pytest.approx(float(exact[low:high].sum()), rel=1e-10)


@pytest.mark.parametrize("exponent", [-50.0, 0.0, 1.0, 3.0, 50.0])
def test_power_laws_are_integrated_exactly(exponent):
    law = Unevenness(form="power-law", amplitude=1e-8, exponent=exponent)
    n = np.array([0.02, 30.0])
    primitive = np.log(n) if exponent == 1.0 else n ** (1.0 - exponent) / (1.0 - exponent)
    assert float(law.band_mean_square(*(2.0 * np.pi * n))) == pytest.approx(
        1e-8 * (primitive[1] - primitive[0]), rel=1e-12
    )


def test_table_of_levels_returns_its_levels():
    wavelength = third_octaves.midbands(0.5, 50.0)
    level = 30.0 + 18.0 * np.log10(wavelength)
    table = Unevenness(form="table", wavelength=tuple(wavelength.tolist()), level=tuple(level.tolist()))
    octaves = table.third_octaves(0.5, 50.0)
    np.testing.assert_allclose(octaves.wavelength, wavelength)
    np.testing.assert_allclose(
        references.level(octaves.mean_square, third_octaves.UNEVENNESS_REFERENCE), level, rtol=0, atol=0.05
    )


def test_third_octaves_of_the_paper():
    octaves = Unevenness(form="fra-hamid-yang", line_class=3).third_octaves(0.5, 40.0)
    assert octaves.wavelength[0] == pytest.approx(0.501187, rel=1e-6)
    assert octaves.wavelength.size == 20
    level = references.level(octaves.mean_square, third_octaves.UNEVENNESS_REFERENCE)
    assert np.all(np.diff(level) > 0.0)
    # By hand at 10 m: S(n) dn = 3.277e-6 m³ × 0.02308 cycles/m, and the curvature of the power law.
    assert level[octaves.wavelength.searchsorted(9.99)] == pytest.approx(48.8, abs=0.1)
    assert octaves.extrapolated_share[0] == 1.0
    assert octaves.extrapolated_share[-1] == 0.0


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"form": "fra"}, r"Unevenness\.form = 'fra'"),
        ({"form": "fra-av"}, "needs line_class, here given: none"),
        ({"form": "fra-av", "line_class": 7}, r"line_class = 7: should be less than or equal to 6"),
        ({"form": "german-low", "line_class": 3}, "needs no further key, here given: line_class"),
        ({"form": "table", "wavelength": (1.0, 2.0)}, "needs wavelength_m and level_db or wavelength_m and"),
        (
            {"form": "table", "wavelength": (1.0, 2.0), "level": (1.0, 2.0), "spectral_density": (1.0, 2.0)},
            "here given: wavelength_m, level_db, spectral_density_m3",
        ),
        ({"form": "table", "wavelength": (1.0, 2.0), "level": (1.0,)}, "wavelength_m has 2 values"),
        ({"form": "table", "wavelength": (1.0, 1.0), "level": (1.0, 2.0)}, "ascend or descend"),
        ({"form": "table", "wavelength": (1.0, -2.0), "level": (1.0, 2.0)}, r"wavelength.*\[1\] = -2"),
        (
            {"form": "table", "wavelength": (1.0, 1.0001), "spectral_density": (1e-7, 2e-7)},
            "slope at its long end = -6.93e\\+03: .* must be 50 or less",
        ),
        (
            {"form": "table", "wavelength": (4.0, 1.0, 0.99), "spectral_density": (1e-7, 1e-8, 1e-9)},
            "slope at its short end = -229: .* must be 50 or less",
        ),
        ({"form": "table", "wavelength": (1.0, 2.0), "level": (1e4, 1e4)}, "must be positive and finite"),
        ({"form": "power-law", "amplitude": 1e-8, "exponent": 60.0}, "exponent = 60: .* must be 50 or less"),
        ({"form": "power-law", "amplitude": 1e-8}, "needs amplitude_m3 and exponent"),
        (
            {"form": "sncf-good", "minimum_wavelength": 3.0, "maximum_wavelength": 2.0},
            "minimum_wavelength_m = 3 m must be below",
        ),
        ({"form": "sncf-good", "maximum_wavelength": 0.0}, "maximum_wavelength"),
    ],
)
def test_refusals(parameters, message):
    with pytest.raises(InputError, match=message):
        Unevenness(**parameters)


@pytest.mark.parametrize("beta", [0.0, -1.0, float("nan"), float("inf")])
def test_wavenumbers_are_positive(beta):
    unevenness = Unevenness(form="german-low")
    with pytest.raises(InputError, match="wavenumber"):
        unevenness.psd([1.0, beta])
    with pytest.raises(InputError, match="wavenumbers"):
        unevenness.band_mean_square(beta, 1.0)


def test_bands_ascend():
    with pytest.raises(InputError, match="ascending"):
        Unevenness(form="german-low").band_mean_square(2.0, 1.0)
