"""The track's response to a load on the rail, on ground of a known compliance."""

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from railvib.numerics.jit import fused_kernel, inline
from railvib.numerics.vector_math import LANES, reciprocal
from railvib.parameters.track import Track


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
    CONVENTIONS section 3; Sheng, Jones and Petyt (1999). Written with the ground's flexibility, so that a
    rigid or a very stiff ground needs no division by it.
    """
    given = np.asarray(wavenumber, float), np.asarray(omega, float), np.asarray(compliance, complex)
    shape = np.broadcast_shapes(*(each.shape for each in given))
    beta, w, c = (each.ravel() if each.shape == shape else _filled(each, shape) for each in given)
    rail, force = _responses(beta, w, c, *parameters(track))
    return rail.reshape(shape), force.reshape(shape)


def _filled(value: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return values broadcast to a shape, flat; `np.broadcast_to` would cost more than the track itself."""
    filled = np.empty(shape, value.dtype)
    filled[...] = value
    return filled.ravel()


@lru_cache(64)
def parameters(track: Track) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
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


@fused_kernel
def _responses(beta, omega, compliance, bed, support, pad, rail):
    """Return the rail's displacement and the ground's force of many β, ω̂ and C."""
    n = beta.shape[0]
    displacement = np.empty(n, np.complex128)
    pressed = np.empty(n, np.complex128)
    q = np.empty(6 * LANES)
    for first in range(0, n, LANES):
        m = min(LANES, n - first)
        for i in range(m):
            q[i] = compliance[first + i].real
            q[LANES + i] = compliance[first + i].imag
            q[4 * LANES + i] = beta[first + i]
            q[5 * LANES + i] = omega[first + i]
        load(m, q, bed, support, pad, rail)
        for i in range(m):
            force = reciprocal(complex(q[2 * LANES + i], q[3 * LANES + i]))
            displacement[first + i] = complex(q[i], q[LANES + i]) * force
            pressed[first + i] = force
    return displacement, pressed


@fused_kernel
def load(n, q, bed, support, pad, rail):
    """Find what a unit force on the ground takes: displacement of the rail and force on it, per lane.

    From the ground up, so that nothing is divided by but the stiffness of layers. `q` holds C, room for two,
    β and ω̂, each of `LANES` values, of which n count; then displacement and force take the first four places.
    """
    n = min(n, LANES)
    for i in range(n):
        q[2 * LANES + i] = 1.0
        q[3 * LANES + i] = 0.0
    for layer in range(bed.shape[0]):
        k0, mass, loss = bed[layer]
        for i in range(n):
            below = complex(q[i], q[LANES + i])
            force = complex(q[2 * LANES + i], q[3 * LANES + i])
            omega = q[5 * LANES + i]
            k = complex(k0, _sign(omega) * k0 * loss)
            inertia = omega * omega * mass
            diagonal = k - inertia / 3.0
            coupling = k + inertia / 6.0
            above = (force + diagonal * below) * reciprocal(coupling)
            force = diagonal * above - coupling * below
            q[i] = above.real
            q[LANES + i] = above.imag
            q[2 * LANES + i] = force.real
            q[3 * LANES + i] = force.imag
    static = 1.0 / pad[0]
    damped = reciprocal(complex(pad[0], pad[0] * pad[2]))
    for i in range(n):
        u = complex(q[i], q[LANES + i])
        force = complex(q[2 * LANES + i], q[3 * LANES + i])
        b2 = q[4 * LANES + i] * q[4 * LANES + i]
        w2 = q[5 * LANES + i] * q[5 * LANES + i]
        sign = _sign(q[5 * LANES + i])
        force += _beam(support, b2 * b2, w2, sign) * u
        u += complex(static if sign == 0.0 else damped.real, sign * damped.imag) * force
        force += _beam(rail, b2 * b2, w2, sign) * u
        q[i] = u.real
        q[LANES + i] = u.imag
        q[2 * LANES + i] = force.real
        q[3 * LANES + i] = force.imag


@fused_kernel
def times_force(real, imag, force, out):
    """Write compliances of the ground, (n, m), times the force on it, real and imaginary parts in turn."""
    for i in range(real.shape[0]):
        for j in range(real.shape[1]):
            out[i, 2 * j] = real[i, j] * force[2 * j] - imag[i, j] * force[2 * j + 1]
            out[i, 2 * j + 1] = real[i, j] * force[2 * j + 1] + imag[i, j] * force[2 * j]


@inline
def _sign(x):
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@inline
def _beam(beam, b4, w2, sign):
    """Return the dynamic stiffness EI (1 + iη sgn ω) β⁴ − ω² m of a beam."""
    bending = beam[0] * b4
    return complex(bending - w2 * beam[1], sign * bending * beam[2])
