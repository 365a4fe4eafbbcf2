"""Common poles of known functions, and the parts that lead to them."""

import numpy as np
import pytest

from railvib.soil.barycentric import (
    Range,
    _smallest_singular_vector,
    common_poles,
    fit_range,
    residues,
    residues_through_zero,
)

WITHIN = Range(scale=0.05, largest=300.0, square=30.0, loss_factor=0.02)
POLE = np.array([1.0 - 0.1j, 4.0 - 1.0j, -2.0 + 0j, 90.0 - 20.0j, -500.0 + 0j])


def functions(r):
    """Two functions on the same poles; the second has no residue at the first pole."""
    terms = 1.0 / (r[:, None] ** 2 - POLE)
    return np.stack([0.3 + terms @ [1.0, 2.0, -1.0j, 5.0, 40.0], 0.1 + terms @ [0.0, 1.0j, 3.0, -2.0, 1.0]])


@pytest.mark.parametrize("which", [slice(0, 1), slice(0, 2)], ids=["one function", "two functions"])
def test_poles_of_rational_functions(which):
    poles = common_poles(lambda r: functions(r)[which], WITHIN, 1e-12, 60)
    for expected in POLE:
        assert np.abs(poles.pole - expected).min() < 1e-7 * abs(expected)
    for samples in (poles.seen, poles.unseen):
        np.testing.assert_array_equal(samples.value, functions(WITHIN.wavenumber(samples.x))[which])
    assert poles.start.pole.size == poles.start.support.size - 1


def test_samples_that_check_are_not_those_that_fit():
    poles = common_poles(functions, WITHIN, 1e-10, 60)
    assert np.intersect1d(poles.seen.x, poles.unseen.x).size == 0
    assert poles.seen.x[0] == 0.0
    assert WITHIN.wavenumber(poles.seen.x[-1]) == pytest.approx(WITHIN.largest)


def test_a_start_keeps_its_supports():
    cold = common_poles(functions, WITHIN, 1e-10, 60)
    warm = common_poles(functions, WITHIN, 1e-10, 60, cold.start)
    np.testing.assert_allclose(warm.start.support, cold.start.support, rtol=1e-14)
    for expected in POLE:
        assert np.abs(warm.pole - expected).min() < 1e-7 * abs(expected)


def test_no_more_terms_than_allowed():
    poles = common_poles(lambda r: np.exp(5j * r)[None], WITHIN, 1e-14, 30)
    assert 30 <= poles.start.support.size <= 33


def test_poles_too_close_to_the_axis_are_dropped():
    """A ground cannot resonate more sharply than its layer that is damped least."""

    def sharp(r):
        return (1.0 / (r**2 + 2.0) + 1.0 / (r**2 - (3.0 - 1e-6j) ** 2))[None]

    assert (np.abs(np.sqrt(common_poles(sharp, WITHIN, 1e-9, 60).pole) - 3.0) > 0.1).all()
    less = Range(WITHIN.scale, WITHIN.largest, WITHIN.square, 1e-6)
    assert np.abs(np.sqrt(common_poles(sharp, less, 1e-9, 60).pole) - 3.0).min() < 1e-5


def test_smallest_singular_vector():
    rng = np.random.default_rng(1)
    matrix = rng.normal(size=(40, 9)) + 1j * rng.normal(size=(40, 9))
    matrix[:, 4] = matrix[:, 2] + 1e-5 * matrix[:, 0]
    expected = np.linalg.svd(matrix)[2][-1].conj()
    vector = _smallest_singular_vector(np.asfortranarray(matrix))
    assert abs(np.vdot(vector, expected)) == pytest.approx(1.0, abs=1e-9)


def test_residues():
    r = np.linspace(0.1, 40.0, 300)
    f = functions(r)[0]
    residue, constant = residues(r, f, np.abs(f), POLE)
    np.testing.assert_allclose(residue, [1.0, 2.0, -1.0j, 5.0, 40.0], rtol=1e-9)
    assert constant == pytest.approx(0.3, rel=1e-9)
    through_zero = r**2 * (f - 0.3)
    np.testing.assert_allclose(
        residues_through_zero(r, through_zero, np.abs(f), POLE), [1.0, 2.0, -1.0j, 5.0, 40.0], rtol=1e-9
    )


def test_range_reaches_as_far_as_asked_for(greby):
    usual = fit_range(greby, 20.0)
    assert fit_range(greby, 20.0, 10.0) == usual
    assert fit_range(greby, 20.0, 5000.0).largest == 5000.0
    assert usual.loss_factor == min(layer.loss_factor for layer in greby.layers)
