"""Soils of any number of layers, in the form of study files."""

from typing import Any

from railvib import library
from railvib.parameters.ground import Ground


def graded_soil(layers: int, stiffness: float = 1.0) -> dict[str, Any]:
    """Return a soil whose shear speed grows from 100 to 300 m/s over 8 m, in equal layers on a half-space.

    `stiffness` multiplies all speeds.
    """
    rows = []
    for i in range(layers):
        speed = stiffness * (100.0 + 200.0 * (i / (layers - 1) if layers > 1 else 1.0))
        row = {
            "shear_speed_m_s": round(speed, 6),
            "dilatational_speed_m_s": round(2.0 * speed, 6),
            "density_kg_m3": 1900.0,
            "loss_factor": 0.1,
        }
        rows.append(row if i == layers - 1 else {"thickness_m": 8.0 / (layers - 1), **row})
    return {"layers": rows}


def ground(layers: int) -> Ground:
    """Return a soil of the library with this number of layers, or the graded one if there is none."""
    for name in library.names("soil"):
        soil = library.load("soil", name)
        if len(soil.layers) == layers:
            return soil
    return Ground(**graded_soil(layers))
