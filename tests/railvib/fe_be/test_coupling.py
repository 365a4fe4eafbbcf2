"""Coupling of rails, sleepers, bed and ground: on rigid ground the semi-analytical track, and equilibrium."""

import numpy as np
import pytest

from railvib.fe_be.coupling import DOWN, condense_columns, coupled_response, strip_edges
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.track import Track, TrackLayer
from railvib.transfer.track_response import track_response

BETA = np.array([0.0, 0.05, 0.4, 1.5, 6.0])
SECTION = CrossSection(bed="columns", contact="smooth", elements=4)
STRIPS = 3 * SECTION.elements
SLAB = Track(
    form="slab",
    rail_bending_stiffness=12.8e6,
    rail_mass=120.0,
    pad_stiffness=4e8,
    pad_loss_factor=0.2,
    contact_width=3.2,
    slab_bending_stiffness=2e8,
    slab_mass=2500.0,
    slab_loss_factor=0.02,
    mat=TrackLayer(stiffness=1e8, mass=300.0, loss_factor=0.1),
)


@pytest.fixture(params=["ballasted", "embankment", "slab"])
def any_track(request, track):
    embankment = TrackLayer(stiffness=2e9, mass=5000.0, loss_factor=0.1)
    return {
        "ballasted": track,
        "embankment": track.model_copy(update={"layers": (*track.layers, embankment)}),
        "slab": SLAB,
    }[request.param]


def on_rigid_ground(track, section, omega, bed):
    still = np.zeros((BETA.size, STRIPS, STRIPS), complex)
    return coupled_response(track, section, BETA, omega, bed, still, still[:, :1])


@pytest.mark.parametrize("frequency", [5.0, 40.0, 200.0])
def test_columns_on_rigid_ground_are_the_semi_analytical_track(any_track, frequency):
    omega = 2.0 * np.pi * frequency
    response = on_rigid_ground(any_track, SECTION, omega, condense_columns(any_track, SECTION, omega))
    rail, force = track_response(any_track, BETA, omega, 0.0)
    np.testing.assert_allclose(response.rail, rail, rtol=1e-10)
    # The strips of one half carry half of the force.
    np.testing.assert_allclose(2.0 * response.force[:, 2].sum(axis=1), force, rtol=1e-10)
    np.testing.assert_array_equal(response.force[:, :2], 0.0)


def test_a_load_at_rest_passes_through_pads_and_bed_in_series(track):
    response = on_rigid_ground(track, SECTION, 1e-6, condense_columns(track, SECTION, 1e-6))
    (ballast,) = track.bed
    springs = (
        track.pad_stiffness * (1.0 + 1j * track.pad_loss_factor),
        ballast.stiffness * (1.0 + 1j * ballast.loss_factor),
    )
    assert response.rail[0] == pytest.approx(sum(1.0 / spring for spring in springs), rel=1e-9)
    assert response.force[0, 2].sum() == pytest.approx(0.5, rel=1e-9)


def test_columns_share_the_bed_by_their_width(any_track):
    matrix = condense_columns(any_track, SECTION, 2.0 * np.pi * 25.0)
    np.testing.assert_array_equal(matrix, matrix.T)
    strip = np.arange(2 * SECTION.elements, STRIPS)
    share = np.diff(strip_edges(any_track, SECTION)) / any_track.half_width
    flexibility = matrix[strip, strip] * share
    np.testing.assert_allclose(flexibility, flexibility[0], rtol=1e-13)
    np.testing.assert_array_equal(matrix[strip, STRIPS + DOWN], matrix[strip[0], STRIPS + DOWN])


def test_a_bed_without_layers_is_refused(track):
    with pytest.raises(ValueError, match="needs a layer"):
        condense_columns(track.model_copy(update={"layers": ()}), SECTION, 1.0)
