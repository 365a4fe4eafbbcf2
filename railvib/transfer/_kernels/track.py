"""The track's response to a load on the rail, from the ground's compliance up.

Arrays of a track are those of `railvib.transfer.track_response.track_parameters`.
"""

import numpy as np

from railvib.numerics.jit import fused_kernel, inline
from railvib.numerics.vector_math import LANES, reciprocal


@fused_kernel
def responses(beta, omega, compliance, bed, support, pad, rail):
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
        track_under_unit_force(m, q, bed, support, pad, rail)
        for i in range(m):
            force = reciprocal(complex(q[2 * LANES + i], q[3 * LANES + i]))
            displacement[first + i] = complex(q[i], q[LANES + i]) * force
            pressed[first + i] = force
    return displacement, pressed


@fused_kernel
def track_under_unit_force(n, q, bed, support, pad, rail):
    """Replace q by displacement of the rail and force on it, per unit force on the ground, in n lanes.

    From the ground up, so that only the stiffness of layers is divided by. `q` holds C, two rows of scratch,
    β and ω̂, in rows of `LANES` values; complex values take a row each for real and imaginary part.
    Displacement and force replace the first four rows.
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
def multiply_by_force(real, imag, force, out):
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
