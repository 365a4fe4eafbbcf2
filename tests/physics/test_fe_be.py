"""The FE/BE model: what it must become when its parts are taken away, and what judges it as a whole."""

import numpy as np
import pytest

from railvib.fe_be.boundary_elements import graded_edges
from railvib.fe_be.coupling import condense_columns, strip_edges
from railvib.fe_be.model import fe_be_blocks, fe_be_response
from railvib.fe_be.solid_bed import CondensedBed, SolidBed
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.track import Track, TrackLayer
from railvib.soil.compliance import line_compliance
from railvib.transfer.track_response import track_response
from tests.physics.fe_pml import Extent, GroundSection
from tests.physics.test_strips import strips

BETA = np.array([0.0, 0.01, 0.1, 0.5, 1.0, 3.0, 10.0, 19.0])
OFFSETS = [0.0, 8.0, 32.0]
SEMI_ANALYTICAL = CrossSection(bed="columns", contact="smooth", displacement="centre", elements=1)


def embanked(track):
    return track.model_copy(
        update={"layers": (*track.layers, TrackLayer(stiffness=2e9, mass=5000.0, loss_factor=0.1))}
    )


@pytest.mark.parametrize("frequency", [2.0, 20.0, 80.0])
@pytest.mark.parametrize("layers", ["ballast", "ballast and embankment"])
def test_one_strip_and_lumped_ballast_are_the_semi_analytical_model(
    greby, horstwalde, track, frequency, layers
):
    track = track if layers == "ballast" else embanked(track)
    for ground in (greby, horstwalde):
        compliance = line_compliance(ground, track.half_width, BETA[:, None], OFFSETS, frequency)
        rail, force = track_response(track, BETA, 2.0 * np.pi * frequency, compliance[:, 0])
        judged = force[:, None] * compliance
        found = fe_be_response(ground, track, SEMI_ANALYTICAL, frequency, BETA, OFFSETS)
        np.testing.assert_allclose(found.rail, rail, rtol=1e-6)
        for y in range(3):
            np.testing.assert_allclose(
                found.ground[y], judged[:, y], rtol=1e-6, atol=1e-6 * abs(judged[:, y]).max()
            )


@pytest.mark.parametrize("form", ["ballasted", "slab"])
def test_tables_of_the_degenerate_model_are_those_of_the_semi_analytical_one(greby, track, tables, form):
    if form == "slab":
        track = Track(
            form="slab",
            rail_bending_stiffness=12.8e6,
            rail_mass=120.0,
            pad_stiffness=4e8,
            pad_loss_factor=0.2,
            contact_width=3.2,
            slab_bending_stiffness=2e8,
            slab_mass=2500.0,
            slab_loss_factor=0.02,
            mat=TrackLayer(stiffness=1e8, mass=0.0, loss_factor=0.1),
        )
    made = fe_be_blocks(greby, track, SEMI_ANALYTICAL, 1, [RAIL, Receiver(8.0)], 1e-2)
    judged = tables(greby, track, range(1, 2), (RAIL, Receiver(8.0)), 1e-2)
    for receiver, function in judged.items():
        np.testing.assert_array_equal(made[receiver].shared.wavenumber, function.blocks[1].shared.wavenumber)
        direct = function.blocks[1].transfer
        np.testing.assert_allclose(made[receiver].transfer, direct, rtol=1e-6, atol=1e-6 * abs(direct).max())


def test_bed_has_the_stiffness_and_mass_that_it_stands_for(track):
    """Under uniform strain: no lateral expansion at ν = 0, so k_B and m_B come out exactly."""
    section = CrossSection(poisson_ratio=0.0, elements=3, rows=2)
    edge = strip_edges(track, section)
    solid = SolidBed(track, section, edge)
    omega = 2.0 * np.pi * 20.0
    found = solid.condense(0.0, omega)
    n = edge.size - 1
    lumped = condense_columns(track, section, omega)
    strip = 2 * n + np.arange(n)
    share = np.diff(edge) / track.half_width
    # A bar's distributed mass against the consistent one of a single element: equal up to (ω/ω₁)⁴.
    bar = omega * np.sqrt(1740.0 / (4640e6 * (1.0 + 0.04j)))
    uniform = share @ found[np.ix_(strip, strip)] @ share
    assert abs(uniform / (np.tan(bar) / bar / (2320e6 * (1.0 + 0.04j))) - 1.0) < 1e-6
    np.testing.assert_allclose(found[strip, -1], 1.0 / np.cos(bar), rtol=1e-6)
    np.testing.assert_allclose(lumped[strip, -1], found[strip, -1], rtol=1e-3)
    assert abs(lumped[-1, -1] / found[-1, -1] - 1.0) < 1e-3


def test_interpolated_bed_is_the_factorised_one(track):
    section = CrossSection(elements=4, rows=2)
    solid = SolidBed(track, section, strip_edges(track, section))
    bed = CondensedBed(solid, (25.0, 130.0), 20.0)
    rng = np.random.default_rng(2)
    beta = rng.uniform(0.0, 20.0, 6)
    for frequency in (25.0, 64.0, 130.0):
        omega = 2.0 * np.pi * frequency
        direct = np.array([solid.condense(each, omega) for each in beta])
        size = np.sqrt(abs(np.einsum("nii->ni", direct)).max(axis=0))
        assert (abs(bed.at(beta, omega) - direct) / (size[:, None] * size)).max() < 1e-6


def test_coupling_by_whole_matrices(greby, track):
    """The condensed coupling against finite elements and Bᵀ A⁻¹ B of the ground in one stiffness matrix."""
    section = CrossSection(elements=4, rows=2)
    edge = strip_edges(track, section)
    beta, frequency = 0.8, 30.0
    omega = 2.0 * np.pi * frequency
    solid = SolidBed(track, section, edge)
    k0, k1, k2 = solid._stiffness
    dynamic = (k0 + beta * k1 + beta**2 * k2 - omega**2 * solid._mass).toarray()
    base = np.zeros((3 * section.elements, dynamic.shape[0]))
    base[:, solid._interior] = solid._base
    dynamic += base.T @ np.linalg.solve(strips(greby, edge, beta, frequency), base)
    keep = np.zeros((dynamic.shape[0], solid._interior.size + 2))
    keep[solid._interior, np.arange(solid._interior.size)] = 1.0
    keep[solid._boundary, -2:] = solid._rigid
    whole = np.zeros((keep.shape[1] + 1,) * 2, complex)
    whole[:-1, :-1] = keep.T @ dynamic @ keep
    pad = 0.5e9 * (1.0 + 0.1j)
    whole[-3, -3] -= 0.5 * omega**2 * track.sleeper_mass
    whole[-2, -2] += pad - 0.5 * omega**2 * track.sleeper_mass
    whole[-2, -1] = whole[-1, -2] = -pad
    whole[-1, -1] = pad + 6.4e6 * (1.0 + 0.01j) * beta**4 - omega**2 * 60.0
    load = np.zeros(whole.shape[0])
    load[-1] = 0.5
    assert (
        abs(
            fe_be_response(greby, track, section, frequency, beta).rail[0] / np.linalg.solve(whole, load)[-1]
            - 1.0
        )
        < 1e-9
    )


@pytest.mark.parametrize(("beta", "frequency"), [(0.5, 20.0), (1.2, 20.0), (0.3, 8.0)])
def test_track_on_soil_equals_finite_elements_with_pml(greby, track, beta, frequency):
    section = CrossSection(elements=6, rows=2)
    whole = GroundSection(
        greby,
        graded_edges(track.half_width, 6),
        beta,
        frequency,
        Extent(5.0, 5.0, 8.0, 0.5),
        (track, section),
    )
    found = fe_be_response(greby, track, section, frequency, beta)
    assert abs(found.rail[0] / whole.rail(track) - 1.0) < 0.01


def test_forces_balance_the_load_where_nothing_else_carries(greby, track):
    """At β = 0 and low frequency no rail bends: the load goes through the strips into the ground."""
    found = fe_be_response(greby, track, CrossSection(elements=4, rows=2), 0.2, 0.0)
    assert abs(2.0 * found.force[0, 2].sum() - 1.0) < 2e-3
    assert np.abs(found.force[0, 0]).max() < 1e-12


def test_mesh_converges(greby, horstwalde, track):
    """Bonded, with a bed of finite stiffness, tractions at the edge are milder than under a rigid strip."""
    beta = np.array([0.0, 0.3, 1.2, 4.0])
    for ground in (greby, horstwalde):
        found = {
            n: fe_be_response(ground, track, CrossSection(elements=n, rows=rows), 20.0, beta, [8.0])
            for n, rows in ((4, 2), (8, 3), (16, 6))
        }
        for part in ("rail", "ground"):
            exact = getattr(found[16], part)
            coarse, usual = (abs(getattr(found[n], part) - exact).max() / abs(exact).max() for n in (4, 8))
            assert usual < 2e-3
            assert usual < 0.4 * coarse


def test_range_of_wavenumbers(track, greby):
    """Where tables end, at 2000 pads, a track is the rail on its pads, to 1e-6 of its largest response."""
    beta = 20.0
    found = fe_be_response(greby, track, CrossSection(elements=4, rows=2), 20.0, [0.0, beta]).rail
    rigid, _force = track_response(track, beta, 2.0 * np.pi * 20.0, 0.0)
    assert abs(found[1] - rigid) < 1e-6 * abs(found[0])
