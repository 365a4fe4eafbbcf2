"""Flexibility of strips on the ground: reciprocity, passivity, and the closed form of the compliance."""

import numpy as np
import pytest

from railvib.fe_be.boundary_elements import graded_edges, receiver_flexibility, strip_flexibility
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.strip import mean_fit_reach, strip_compliance, strip_mean
from railvib.soil.tensor_fit import fit_tensor

HALF_WIDTH, FREQUENCY = 1.6, 20.0
BETA = np.array([0.0, 0.3, 2.0, 10.0])
OFFSET = np.array([0.0, 3.0, 16.0])


@pytest.fixture(scope="module", params=["horstwalde", "greby"])
def ground(request):
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module")
def fit(ground):
    return fit_tensor(ground, FREQUENCY, 1e-9, largest=mean_fit_reach(HALF_WIDTH))


def test_edges_reach_from_the_centre_to_the_edge_and_shrink():
    edge = graded_edges(HALF_WIDTH, 6)
    assert edge[0] == 0.0
    assert edge[-1] == HALF_WIDTH
    assert np.all(np.diff(edge) > 0.0)
    assert np.all(np.diff(edge, 2) < 0.0)


def test_strips_are_reciprocal_and_give_no_energy(fit):
    flexibility = strip_flexibility(fit, BETA, graded_edges(HALF_WIDTH, 4))
    size = np.abs(flexibility).max(axis=(1, 2), keepdims=True)
    assert np.all(np.abs(flexibility - flexibility.swapaxes(1, 2)) <= 1e-13 * size)
    # The power that forces f feed in is −ω/2 Im(fᴴ F f): F is symmetric, so Im F has no positive eigenvalue.
    assert np.all(np.linalg.eigvalsh(flexibility.imag) <= 1e-9 * size[:, 0])


def test_a_single_strip_is_the_closed_form_of_the_compliance(ground, fit):
    """A force on the right half has its image on the left one, so twice the load of the closed form."""
    edge = graded_edges(HALF_WIDTH, 1)
    scalar = fit_flexibility(ground, FREQUENCY, 1e-9, largest=mean_fit_reach(HALF_WIDTH))
    vertical = strip_flexibility(fit, BETA, edge)[:, 2, 2]
    # Both fits are to 1e-9 of Q33; the sums over their poles lose some digits.
    np.testing.assert_allclose(vertical, 2.0 * strip_mean(scalar, BETA, HALF_WIDTH), rtol=1e-6)
    beside = receiver_flexibility(fit, BETA, edge, OFFSET)[:, :, 2]
    judged = 2.0 * strip_compliance(scalar, BETA, HALF_WIDTH, OFFSET).T
    np.testing.assert_allclose(beside, judged, rtol=1e-6, atol=1e-8 * np.abs(judged).max())


def test_strips_of_one_traction_act_as_the_strip_that_they_divide(fit):
    whole, edge = np.array([0.0, HALF_WIDTH]), graded_edges(HALF_WIDTH, 5)
    share = np.diff(edge) / HALF_WIDTH
    parts = strip_flexibility(fit, BETA, edge).reshape(BETA.size, 3, 5, 3, 5)
    together = np.einsum("i,naibj,j->nab", share, parts, share)
    undivided = strip_flexibility(fit, BETA, whole)
    size = np.abs(undivided).max()
    np.testing.assert_allclose(together, undivided, rtol=1e-9, atol=1e-12 * size)
    receivers = receiver_flexibility(fit, BETA, edge, OFFSET).reshape(BETA.size, OFFSET.size, 3, 5) @ share
    undivided = receiver_flexibility(fit, BETA, whole, OFFSET)
    np.testing.assert_allclose(receivers, undivided, rtol=1e-9, atol=1e-12 * np.abs(undivided).max())
