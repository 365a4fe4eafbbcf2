"""Recomputes fe_pml.csv and rail_receptance.csv, and prints the differences row by row.

Run from the top of the repository: ``python -m tests.data.finite_elements [--elements]``.

The files come from a 2.5D finite element program with perfectly matched layers that shares nothing with the
flexibility method, Richardson-extrapolated from several meshes; its uncertainties are stated in the files.
Beside its columns stand those of direct quadrature, which this script repeats: of C(β, y) over γ in
fe_pml.csv, and of the track on it over β in rail_receptance.csv. With ``--elements`` the finite elements of
tests/physics/fe_pml.py take the place of the outside program: two meshes, extrapolated, some minutes per row;
one mesh of 0.8 m is within 4e-3 of C(β, 0) in every row. Neither file is written.
"""

import cmath
import sys

import numpy as np
from scipy.special import roots_legendre

from railvib import library
from railvib.soil.quadrature import strip_compliance_by_quadrature
from railvib.transfer.track_response import track_response
from tests.consistency.reference import rows, soil
from tests.physics.fe_pml import Extent, GroundSection

HALF_WIDTH = 1.6
TOLERANCE = 1e-8
LARGEST, BEYOND = 20.0, 1280.0
"""Wavenumbers up to which the ground counts, and the rail on its pads; rad/m."""
_NODE, _WEIGHT = roots_legendre(8)


def compliance_by_quadrature(ground, wavenumber, offsets, frequency):
    """Return C(β, y) by direct quadrature over γ, m²/N, (offsets,)."""
    return strip_compliance_by_quadrature(ground, HALF_WIDTH, abs(wavenumber), offsets, frequency, TOLERANCE)


def compliance_by_elements(ground, wavenumber, offsets, frequency, element=0.8):
    """Return C(β, y) by finite elements of a size that divides 1.6 m, m²/N; offsets are multiples of it."""
    reach = max(*offsets, 8.0)
    extent = Extent(
        width=reach + HALF_WIDTH,
        depth=16.0,
        absorbing=max(ground.slowest_speed / frequency, 8.0),
        size=element,
        strength=6.0,
        absorbing_elements=14,
    )
    strips = round(2.0 * HALF_WIDTH / element) * 2
    edge = np.linspace(0.0, HALF_WIDTH, strips + 1)
    _, displacement = GroundSection(ground, edge, wavenumber, frequency, extent).strips(np.array(offsets))
    # Unit forces on the strips of one half; under a uniform pressure each takes its share of half the load.
    return 0.5 * displacement[:, 2 * strips :].sum(axis=1) / strips


def extrapolated_compliance(ground, wavenumber, offsets, frequency):
    """Return C(β, y) of two meshes, extrapolated as their error falls with the square of the size."""
    coarse, fine = (
        compliance_by_elements(ground, wavenumber, offsets, frequency, size) for size in (0.8, 0.4)
    )
    return fine + (fine - coarse) / 3.0


def rail_receptance(name, frequency, speed, compliance=compliance_by_quadrature):
    """Return the rail's receptance under a load, σ = (1/2π) ∫ H̃_R(β, ω − βv) dβ, m/N.

    Panels end at the waves' slownesses as the moving load sees them, and where ω̂ changes its sign.
    """
    ground, track = soil(name), library.load("track", "ballasted-paper")
    omega = 2.0 * np.pi * frequency
    slowness = np.array([0.2, 0.5, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.3, 2.0, 4.0]) / ground.slowest_speed
    positive, negative = (
        omega * slowness / (1.0 + slowness * speed),
        omega * slowness / (slowness * speed - 1.0),
    )
    edges = [0.0, *np.geomspace(0.5, BEYOND, 24), *positive]
    edges = np.unique([*edges, *(-each for each in edges), *negative, *([omega / speed] if speed else [])])
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    beta = (middle[:, None] + half[:, None] * _NODE).ravel()
    seen = omega - beta * speed
    ground_compliance = np.zeros(beta.size, complex)
    for i in np.flatnonzero(np.abs(beta) < LARGEST):
        (value,) = compliance(ground, abs(beta[i]), [0.0], abs(seen[i]) / (2.0 * np.pi))
        ground_compliance[i] = value if seen[i] > 0.0 else value.conjugate()
    rail, _ = track_response(track, beta, seen, ground_compliance)
    return (rail.reshape(middle.size, -1) @ _WEIGHT) @ half / (2.0 * np.pi)


def strip_columns(row):
    """Return soil, wavenumber, offset, frequency, and the two values of a row of fe_pml.csv."""
    return (
        soil(row["soil"]),
        float(row["wavenumber_rad_m"]),
        float(row["offset_m"]),
        float(row["frequency_hz"]),
        complex(float(row["fe_real"]), float(row["fe_imag"])),
        complex(float(row["quadrature_real"]), float(row["quadrature_imag"])),
    )


def main(elements):
    """Print the differences of all rows."""
    for row in rows("fe_pml"):
        ground, wavenumber, offset, frequency, outside, quadrature = strip_columns(row)
        value = compliance_by_quadrature(ground, wavenumber, [0.0, offset], frequency)[-1]
        text = f"fe_pml.csv {list(row.values())[:4]}: quadrature {abs(value / quadrature - 1.0):.1e}"
        if elements:
            value = extrapolated_compliance(ground, wavenumber, [0.0, offset], frequency)[-1]
            text += f", elements {abs(value / outside - 1.0):.1e}"
        print(text, flush=True)
    for row in rows("rail_receptance"):
        expected = cmath.rect(
            float(row["semi_analytical_magnitude"]), float(row["semi_analytical_phase_rad"])
        )
        value = rail_receptance(row["soil"], float(row["frequency_hz"]), float(row["speed_kmh"]) / 3.6)
        print(f"rail_receptance.csv {list(row.values())[:3]}: {abs(value / expected - 1.0):.1e}", flush=True)


if __name__ == "__main__":
    main(elements="--elements" in sys.argv[1:])
