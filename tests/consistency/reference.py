"""Numbers of other codes, from tests/data; each file says where it comes from."""

import csv
from pathlib import Path

from railvib import library
from railvib.parameters.ground import Ground

DATA = Path(__file__).parents[1] / "data"


def rows(name: str) -> list[dict[str, str]]:
    """Return the rows of a file; lines that begin with # say where the numbers come from."""
    with (DATA / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def damped(ground: Ground, loss_factor: float, speed_factor: float = 1.0) -> Ground:
    """Return a ground with one loss factor, and its speeds multiplied, in all layers."""
    return Ground(
        layers=[
            layer.model_copy(
                update={
                    "loss_factor": loss_factor,
                    "shear_speed": layer.shear_speed * speed_factor,
                    "dilatational_speed": layer.dilatational_speed * speed_factor,
                }
            )
            for layer in ground.layers
        ]
    )


def soil(name: str) -> Ground:
    """Return a soil of the reference files: a soil of the paper, or ``greby-0.05``, Greby with that loss
    factor.
    """
    return damped(library.load("soil", "greby"), 0.05) if name == "greby-0.05" else library.load("soil", name)
