"""The tables of the paper's study, whole or with one key changed."""

import tomllib
from pathlib import Path

PAPER = Path(__file__).parents[3] / "studies" / "paper.toml"
LAYER = {"shear_speed_m_s": 100, "dilatational_speed_m_s": 200, "density_kg_m3": 1800, "loss_factor": 0.1}


def paper():
    return tomllib.loads(PAPER.read_text(encoding="utf-8"))


def changed(path, value):
    """Return the paper's study with one key set, or removed where the value is None."""
    study = paper()
    *parents, last = path.split(".")
    table = study
    for name in parents:
        table = table.setdefault(name, {})
    if value is None:
        del table[last]
    else:
        table[last] = value
    return study
