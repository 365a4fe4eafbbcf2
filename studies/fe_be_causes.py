"""Why the FE/BE model differs from the semi-analytical one: one step at a time, from the one to the other.

    .venv/bin/python studies/fe_be_causes.py [SOIL …]

prints, for the paper's track, train and speed, the change of the moving roughness's level in each one-third
octave that each step makes, and their sum. docs/theory/fe-be.md discusses the table.
"""

import sys

import numpy as np

import railvib
from railvib import library
from railvib.cross_section import CrossSection

MESH = {"elements": 4, "rows": 2}
"""Within 0.1 dB of the verification study's mesh."""
STEPS = {
    "width's average for the centre": CrossSection(bed="columns", contact="smooth", elements=1),
    "rigid sleeper on columns": CrossSection(bed="columns", contact="smooth", elements=4),
    "continuous ballast": CrossSection(contact="smooth", poisson_ratio=0.0, **MESH),
    "horizontal tractions": CrossSection(poisson_ratio=0.0, **MESH),
    "Poisson's ratio 0.2": CrossSection(**MESH),
}


def levels(
    soil: str, approach: str, section: CrossSection | None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return midbands and the levels in dB of the leading axle's force, the rail and the ground."""
    case = railvib.predict(
        ground=library.load("soil", soil),
        track=library.load("track", "ballasted-paper"),
        train=library.load("train", "grona-taget"),
        unevenness=library.load("unevenness", "fra-hamid-yang-3"),
        speed=150.0 / 3.6,
        offsets=[8.0, 32.0],
        approaches=[approach],
        tolerance=1e-2,
        cross_section=section,
    )
    velocity = case.velocity_mean_square.sel(contribution="dynamic").isel(approach=0)
    found = {str(name): velocity.sel(receiver=name).values for name in velocity.receiver.values}
    found["force, leading axle"] = case.force_mean_square.isel(approach=0).sel(axle=1).values
    return case.band.values, {name: 10.0 * np.log10(value) for name, value in found.items()}


def main(soils: list[str]) -> None:
    """Print the steps of each soil and receiver."""
    for soil in soils:
        band, before = levels(soil, "moving-roughness", None)
        first, steps = before, {}
        for name, section in STEPS.items():
            _band, after = levels(soil, "fe-be", section)
            steps[name] = {key: after[key] - before[key] for key in after}
            before = after
        for key in first:
            print(f"\n{soil}, {key}: change of level, dB")
            print("| " + " | ".join(["Hz", *(f"{each:.3g}" for each in band)]) + " |")
            print("|" + " --- |" * (band.size + 1))
            for name, change in {**steps, "together": {k: before[k] - first[k] for k in first}}.items():
                print("| " + " | ".join([name, *(f"{each:.1f}" for each in change[key])]) + " |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or ["horstwalde", "greby"])
