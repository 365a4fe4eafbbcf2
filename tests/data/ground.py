"""Recomputes ground_flexibility.csv and point_load.csv, and prints the largest difference of each file.

Run from the top of the repository: ``python -m tests.data.ground``.

ground_flexibility.csv holds nine digits on which three stiffness-matrix codes agree to eight, one of them in
Octave by another group. It is recomputed by the layers' stiffness matrices in plain NumPy. point_load.csv
holds a Hankel integral of Q33 by direct quadrature, converged to 1e-5; with the same method axitra, a
reflectivity code in Fortran, agrees to 4e-5. It is recomputed by the integral below over railvib's Q33, which
loses no digits at large wavenumbers as stiffness matrices do. Neither file is written.
"""

import math

import numpy as np
from scipy.special import j0, roots_legendre

from benchmarks.peers import stiffness_matrices
from railvib import library
from railvib.soil._kernels.layers import surface_flexibilities
from tests.consistency.reference import damped, rows, soil

PANELS_PER_WAVE = 4
_NODE, _WEIGHT = roots_legendre(12)


def flexibility_error(row):
    """Return the relative difference of one row of ground_flexibility.csv."""
    greby = library.load("soil", "greby")
    if row["damping"] == "mu*(1+0.05i)":
        ground = damped(greby, 0.05)
    else:  # speeds c (1 + 0.025i): their squares are (1 − 0.025²)(1 + iη) with η = 0.05/(1 − 0.025²)
        ground = damped(greby, 0.05 / 0.999375, math.sqrt(0.999375))
    wavenumber, omega = float(row["wavenumber_rad_m"]), 2.0 * math.pi * float(row["frequency_hz"])
    (q,) = stiffness_matrices.by_linear_algebra(ground, np.array([wavenumber]), omega)
    return abs(q / complex(float(row["real_m_pa"]), float(row["imag_m_pa"])) - 1.0)


def point_load(ground, distance, frequency):
    """Return u_z/F = (1/2π) ∫ Q33(ρ) J₀(ρr) ρ dρ at a distance r from a point load on the surface, m/N.

    The static flexibility (1 − ν)/(μρ) of the top layer has the closed form (1 − ν)/(2πμr). What is left of
    Q33 falls like ρ⁻³, and is integrated along the real axis: damping keeps the surface wave's pole off it.
    """
    top = ground.layers[0]
    omega = 2.0 * math.pi * frequency
    static = (1.0 - top.poisson_ratio) / (top.shear_modulus * (1.0 + 1j * top.loss_factor))
    slowest = omega / ground.slowest_speed
    step = min(slowest / 160.0, math.pi / distance / PANELS_PER_WAVE)
    edge = np.concatenate(
        [np.arange(0.0, 3.0 * slowest, step), np.geomspace(3.0 * slowest, 2000.0 * slowest, 20_000)]
    )
    middle, half = 0.5 * (edge[1:] + edge[:-1]), 0.5 * np.diff(edge)
    rho = (middle[:, None] + half[:, None] * _NODE).ravel()
    q = surface_flexibilities(rho, omega, ground.stack(), False)
    integrand = (q * rho - static) * j0(rho * distance)
    integral = (integrand.reshape(middle.size, -1) @ _WEIGHT) @ half
    return integral / (2.0 * math.pi) + static / (2.0 * math.pi * distance)


def point_load_error(row):
    """Return the relative difference of one row of point_load.csv."""
    value = point_load(soil(row["soil"]), float(row["distance_m"]), float(row["frequency_hz"]))
    return abs(value / complex(float(row["real_m_n"]), float(row["imag_m_n"])) - 1.0)


if __name__ == "__main__":
    print(f"ground_flexibility.csv: {max(map(flexibility_error, rows('ground_flexibility'))):.1e}")
    for row in rows("point_load"):
        print(f"point_load.csv: {list(row.values())[:3]} {point_load_error(row):.1e}")
