"""The track: against its equations of motion assembled as a matrix, and its limits."""

import numpy as np
import pytest

from railvib import library
from railvib.errors import InputError
from railvib.parameters.track import Track, TrackLayer
from railvib.transfer.track_response import track_response

SLAB = {
    "form": "slab",
    "rail_bending_stiffness": 12.8e6,
    "rail_mass": 120.0,
    "pad_stiffness": 1e8,
    "slab_bending_stiffness": 1e8,
    "slab_mass": 1700.0,
    "slab_loss_factor": 0.02,
    "contact_width": 2.8,
}


def assembled(track, beta, omega, compliance):
    """Return rail, sleepers or slab, the layers' interfaces and the ground as one dynamic stiffness."""
    sign = np.sign(omega)
    layers = list(track.bed)
    size = 2 + len(layers)
    k = np.zeros((size, size), complex)
    k[0, 0] = (
        track.rail_bending_stiffness * (1 + 1j * sign * track.rail_loss_factor) * beta**4
        - track.rail_mass * omega**2
    )
    pad = track.pad_stiffness * (1 + 1j * sign * track.pad_loss_factor)
    k[:2, :2] += pad * np.array([[1, -1], [-1, 1]])
    if track.form == "slab":
        k[1, 1] += (
            track.slab_bending_stiffness * (1 + 1j * sign * track.slab_loss_factor) * beta**4
            - track.slab_mass * omega**2
        )
    else:
        k[1, 1] -= track.sleeper_mass * omega**2
    for i, layer in enumerate(layers):
        stiffness = layer.stiffness * (1 + 1j * sign * layer.loss_factor)
        own = stiffness * np.array([[1, -1], [-1, 1]]) - omega**2 * layer.mass / 6.0 * np.array(
            [[2, 1], [1, 2]]
        )
        k[1 + i : 3 + i, 1 + i : 3 + i] += own
    k[-1, -1] += 1.0 / compliance
    w = np.linalg.solve(k, np.eye(size)[0])
    return w[0], w[-1] / compliance


def tracks():
    paper = library.load("track", "ballasted-paper")
    embankment = TrackLayer(stiffness=8e8, mass=6000.0, loss_factor=0.08)
    yield paper
    yield paper.model_copy(update={"layers": (*paper.layers, embankment, embankment)})
    yield Track(**SLAB)
    yield Track(**SLAB, mat=TrackLayer(stiffness=5e7, loss_factor=0.1), layers=[embankment])


@pytest.mark.parametrize("track", list(tracks()), ids=["ballasted", "embankment", "slab", "slab-mat"])
@pytest.mark.parametrize("omega", [1e-3, 40.0, 900.0, -300.0])
def test_against_assembled_matrix(track, omega):
    for beta in (0.0, 0.5, 3.0):
        compliance = (3e-9 - 1e-9j) if omega > 0.0 else (3e-9 + 1e-9j)
        rail, force = track_response(track, beta, omega, compliance)
        expected = assembled(track, beta, omega, compliance)
        np.testing.assert_allclose([rail, force], expected, rtol=1e-10)


@pytest.mark.parametrize("track", list(tracks()), ids=["ballasted", "embankment", "slab", "slab-mat"])
def test_negative_frequency_is_the_conjugate(track):
    one = track_response(track, 0.7, 200.0, 2e-9 - 1e-9j)
    other = track_response(track, 0.7, -200.0, 2e-9 + 1e-9j)
    np.testing.assert_allclose(np.conj(one), other, rtol=1e-14)


@pytest.mark.parametrize("track", list(tracks()), ids=["ballasted", "embankment", "slab", "slab-mat"])
def test_passive(track):
    beta = np.linspace(0.0, 5.0, 50)[:, None]
    omega = np.geomspace(1.0, 3000.0, 60)
    rail, _force = track_response(track, beta, omega, 2e-9 * np.exp(-0.5j))
    assert np.all(rail.imag < 0.0)


def test_rigid_ground_and_static_load():
    track = library.load("track", "ballasted-paper")
    rail, force = track_response(track, 0.0, 0.0, 0.0)
    assert rail == pytest.approx(1.0 / track.pad_stiffness + 1.0 / track.layers[0].stiffness)
    assert force == pytest.approx(1.0)  # at rest the ground carries what the rail is given


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"slab_mass": None}, "slab_mass_kg_m: is missing"),
        ({"sleeper_mass": 300.0}, "sleeper_mass_kg_m: does not belong"),
        ({"pad_stiffness": -1.0}, "pad_stiffness = -1"),
        ({"form": "ballasted"}, "sleeper_mass_kg_m: is missing"),
        ({"rail_loss_factor": -0.1}, "rail_loss_factor"),
        ({"contact_width": 0.0}, "contact_width = 0"),
        ({"coupling": "average"}, "coupling = 'average': should be 'centre' or 'mean'"),
        ({"gauge": 1.435}, "gauge"),
    ],
)
def test_refused(change, message):
    with pytest.raises(InputError, match=message):
        Track(**{**SLAB, **change})


def test_ballasted_track_needs_ballast():
    paper = library.load("track", "ballasted-paper").model_dump()
    with pytest.raises(InputError, match=r"layers = \[\]: a ballasted track needs"):
        Track(**{**paper, "layers": ()})


def test_coupling_at_the_centre_is_what_tracks_had_before():
    """An identity is made of what is not None: a track that says `centre` is the one that says nothing."""
    paper = library.load("track", "ballasted-paper")
    centre = Track(**{**paper.model_dump(), "coupling": "centre"})
    assert centre == paper
    assert centre.coupling is None
    assert not centre.follows_mean
    assert Track(**{**paper.model_dump(), "coupling": "mean"}).follows_mean
