"""The condensed bed: reciprocity, passivity, rigid motion, and interpolation."""

import numpy as np
import pytest

from railvib.fe_be.coupling import ALONG, DOWN, strip_edges
from railvib.fe_be.solid_bed import CondensedBed, SolidBed
from railvib.parameters.cross_section import CrossSection

ELEMENTS = 3
STRIPS = 3 * ELEMENTS


@pytest.fixture(scope="module")
def bed(track):
    section = CrossSection(elements=ELEMENTS, rows=2)
    return SolidBed(track, section, strip_edges(track, section))


@pytest.mark.parametrize("beta", [0.0, 0.7, 5.0])
def test_it_is_reciprocal_and_gives_no_energy(bed, beta):
    matrix = bed.condense(beta, 2.0 * np.pi * 30.0)
    size = np.sqrt(np.abs(matrix.diagonal()))
    scaled = matrix / (size[:, None] * size)
    np.testing.assert_allclose(scaled, scaled.T, atol=1e-12)
    flexibility, stiffness = scaled[:STRIPS, :STRIPS], scaled[STRIPS:, STRIPS:]
    assert np.all(np.linalg.eigvalsh(flexibility.imag) < 0.0)
    assert np.all(np.linalg.eigvalsh(stiffness.imag) > -1e-12)


def test_a_rigid_motion_of_the_top_moves_the_base_without_a_force(bed):
    """At rest and without a wavenumber, nothing holds the base."""
    matrix = bed.condense(0.0, 0.0)
    base = matrix[:STRIPS, STRIPS:].reshape(3, ELEMENTS, 2)
    np.testing.assert_allclose(base[0, :, ALONG], 1.0, rtol=1e-10)
    np.testing.assert_allclose(base[2, :, DOWN], 1.0, rtol=1e-10)
    np.testing.assert_allclose(base[[0, 1, 1, 2], :, [DOWN, ALONG, DOWN, ALONG]], 0.0, atol=1e-10)
    stiffness = 1.0 / np.abs(matrix.diagonal()[:STRIPS]).max()
    np.testing.assert_allclose(matrix[STRIPS:, STRIPS:], 0.0, atol=1e-9 * stiffness)


def test_interpolation_is_as_exact_as_it_says_also_on_the_edges_of_its_panels(bed):
    condensed = CondensedBed(bed, (20.0, 40.0), 12.0, 1e-5)
    assert condensed.error <= 1e-5
    assert np.all(np.diff(condensed.edge) > 0.0)
    assert condensed.edge[[0, -1]].tolist() == [0.0, 12.0]
    omega = 2.0 * np.pi * 31.0
    beta = np.sort(np.concatenate([condensed.edge, [0.17, 3.3, 11.9]]))
    direct = np.array([bed.condense(b, omega) for b in beta])
    size = np.sqrt(np.abs(np.einsum("nii->ni", direct)).max(axis=0))
    # The panels are resolved to 1e-5 by their last coefficients, and so are the frequencies: 1e-5 of each.
    assert np.abs((condensed.at(beta, omega) - direct) / (size[:, None] * size)).max() < 2e-5
