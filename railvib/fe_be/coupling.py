"""Track and ground coupled by stiffness in the wavenumber domain: the 2.5D FE/BE model.

At every wavenumber β and frequency ω the forces f between the bed and the ground, strip by strip, follow
from equal displacements of both, A f = T q − F f: A from `railvib.fe_be.boundary_elements`, F and T from the
bed. What the sleepers stand on has the stiffness S + Tᵀ (A + F)⁻¹ T; on it come the sleepers as a rigid
section with mass (or a slab with bending stiffness, stiff along the track), the pads, and two rails as
Euler–Bernoulli beams, 0.75 m right and left of the centre line: on a rigid section, and with a load shared by
both, their distance has no effect. One half of the section stands for both.
"""

from typing import NamedTuple

import numpy as np

from railvib.fe_be.boundary_elements import graded_edges
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.track import Track

ALONG, DOWN = 0, 1
"""Motions of the sleepers: along the track (over i), and downwards."""


class Response(NamedTuple):
    """What a unit load on the rails makes, at n wavenumbers."""

    rail: np.ndarray
    """Displacement of the rails, complex (n,), m²/N."""
    ground: np.ndarray
    """Vertical displacement of the receivers on the ground, complex (receivers, n), m²/N."""
    force: np.ndarray
    """Forces on the strips right of the centre line per load: f_x/i, f_y, f_z, complex (n, 3, strips)."""


def strip_edges(track: Track, section: CrossSection) -> np.ndarray:
    """Return the edges of the strips right of the centre line, m, (elements + 1,)."""
    return graded_edges(track.half_width, section.elements)


def condense_columns(track: Track, section: CrossSection, omega: float) -> np.ndarray:
    """Return the condensed form of a bed of independent columns, complex (3n + 2, 3n + 2).

    As `SolidBed.condense`; columns carry vertical forces only. A bed of several layers is condensed from the
    top down.
    """
    n = section.elements
    stiffness: tuple[complex, complex, complex] | None = None
    for layer in track.bed:
        k = 0.5 * layer.stiffness * (1.0 + 1j * layer.loss_factor * np.sign(omega))
        diagonal, coupling = k - omega**2 * layer.mass / 6.0, -(k + omega**2 * layer.mass / 12.0)
        if stiffness is None:
            stiffness = (diagonal, coupling, diagonal)
        else:
            top, across, bottom = stiffness
            joint = bottom + diagonal
            stiffness = (top - across**2 / joint, -across * coupling / joint, diagonal - coupling**2 / joint)
    if stiffness is None:
        raise ValueError("a bed needs a layer")
    top, across, bottom = stiffness
    share = np.diff(strip_edges(track, section)) / track.half_width
    out = np.zeros((3 * n + 2, 3 * n + 2), complex)
    strip = 2 * n + np.arange(n)
    out[strip, strip] = 1.0 / (bottom * share)
    out[strip, 3 * n + DOWN] = out[3 * n + DOWN, strip] = -across / bottom
    out[3 * n + DOWN, 3 * n + DOWN] = top - across**2 / bottom
    return out


def coupled_response(
    track: Track,
    section: CrossSection,
    beta: np.ndarray,
    omega: float,
    bed: np.ndarray,
    soil: np.ndarray,
    receiver: np.ndarray,
) -> Response:
    """Return the response to a unit load on the rails at one frequency ω > 0.

    Parameters
    ----------
    track, section
        The track and its cross-section.
    beta
        Wavenumbers along the track, rad/m, (n,).
    omega
        Angular frequency, rad/s.
    bed
        Condensed bed, complex (n, 3m + 2, 3m + 2) for m strips, or one for all wavenumbers.
    soil
        The ground's average displacements under the strips per force, complex (n, 3m, 3m); see
        `railvib.fe_be.boundary_elements`.
    receiver
        Vertical displacements of receivers per force, complex (n, receivers, 3m). Where the centre's
        displacement is to follow the track, the first receiver is y = 0.
    """
    n = 3 * section.elements
    active = np.arange(n) if section.contact == "bonded" else np.arange(2 * section.elements, n)
    bed = np.broadcast_to(bed, (beta.size, n + 2, n + 2))
    if section.displacement == "centre":
        soil = np.zeros_like(soil)
        soil[:, 2, 2] = receiver[:, 0, 2]
    flexibility = (soil + bed[:, :n, :n])[:, active[:, None], active]
    drive = bed[:, active, n:]
    per_motion = np.linalg.solve(flexibility, drive)
    support = bed[:, n:, n:] + drive.swapaxes(1, 2) @ per_motion
    # The sleepers' motion along the track follows their vertical one.
    sleeper, along = _sleeper_stiffness(track, beta, omega)
    tilt = np.zeros(beta.size, complex)
    if along is not None and section.bed == "solid":
        tilt = -support[:, ALONG, DOWN] / (support[:, ALONG, ALONG] + along)
    under = support[:, DOWN, DOWN] + tilt * support[:, ALONG, DOWN] + sleeper
    rail, share = _rails(track, beta, omega, under)
    motion = np.stack([tilt, np.ones_like(tilt)], axis=1) * (share / under)[:, None]
    force = np.zeros((beta.size, n), complex)
    force[:, active] = np.einsum("nij,nj->ni", per_motion, motion)
    receivers = np.einsum("nri,ni->rn", receiver, force)
    return Response(rail, receivers, force.reshape(beta.size, 3, section.elements))


def _sleeper_stiffness(track: Track, beta: np.ndarray, omega: float) -> tuple[np.ndarray, np.ndarray | None]:
    """Return stiffnesses of half the sleepers or slab, downwards and along the track; None if held there."""
    if track.form == "slab":
        bending = (track.slab_bending_stiffness or 0.0) * (1.0 + 1j * (track.slab_loss_factor or 0.0))
        return 0.5 * (bending * beta**4 - omega**2 * (track.slab_mass or 0.0)), None
    inertia = np.full(beta.shape, -0.5 * omega**2 * (track.sleeper_mass or 0.0) + 0j)
    return inertia, inertia


def _rails(track: Track, beta: np.ndarray, omega: float, under: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rails' displacement and the force of the pads on one half, per load on both rails."""
    pad = track.pad_stiffness * (1.0 + 1j * track.pad_loss_factor)
    rail = (
        track.rail_bending_stiffness * (1.0 + 1j * track.rail_loss_factor) * beta**4
        - omega**2 * track.rail_mass
    )
    flexibility = 0.5 / under + 1.0 / pad
    loaded = 1.0 / (1.0 + rail * flexibility)
    return flexibility * loaded, 0.5 * loaded
