"""The track's response to a load on the rail, on ground of a known compliance."""

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from railvib.parameters.track import Track
from railvib.transfer._kernels.track import responses


def track_response(
    track: Track, wavenumber: npt.ArrayLike, omega: npt.ArrayLike, compliance: npt.ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rail's displacement and the force on the ground, per unit force on the rail.

    Parameters
    ----------
    track
        The track.
    wavenumber
        β along the track, rad/m.
    omega
        Angular frequency ω̂ that the fixed material sees, rad/s; its sign sets the sign of the damping.
    compliance
        C(β, 0, ω̂) of the ground under the track, m²/N; zero for a rigid ground.

    Returns
    -------
    rail, force : ndarray of complex
        H̃_R = w_R/F in m²/N, and F_ground/F, of the broadcast shape.

    Notes
    -----
    docs/conventions.md, ground and track; Sheng, Jones and Petyt (1999). Written with the ground's
    flexibility, so that a rigid or a very stiff ground needs no division by it.
    """
    values = np.asarray(wavenumber, float), np.asarray(omega, float), np.asarray(compliance, complex)
    shape = np.broadcast_shapes(*(value.shape for value in values))
    rail, force = responses(*(_flat(value, shape) for value in values), *track_parameters(track))
    return rail.reshape(shape), force.reshape(shape)


def _flat(value: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return values broadcast to a shape, flat; `np.broadcast_to` would cost more than the track itself."""
    if value.shape != shape:
        broadcast = np.empty(shape, value.dtype)
        broadcast[...] = value
        value = broadcast
    return value.ravel()


@lru_cache(64)
def track_parameters(track: Track) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return stiffness, mass and loss factor of the bed from below, slab or sleepers, pads and rails."""
    bed = [(layer.stiffness, layer.mass, layer.loss_factor) for layer in reversed(track.bed)]
    if track.form == "slab":
        support = (track.slab_bending_stiffness, track.slab_mass, track.slab_loss_factor or 0.0)
    else:
        support = (0.0, track.sleeper_mass, 0.0)
    return (
        np.array(bed, float).reshape(-1, 3),
        np.array(support, float),
        np.array([track.pad_stiffness, 0.0, track.pad_loss_factor]),
        np.array([track.rail_bending_stiffness, track.rail_mass, track.rail_loss_factor]),
    )
