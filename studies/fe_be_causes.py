"""Why the FE/BE model differs from the semi-analytical one: one assumption after the other is dropped.

    .venv/bin/python studies/fe_be_causes.py [SOIL …]

prints, for the paper's track, the change in dB of the rail's receptance under the load, and of the ground's
mean square along the line per unit load, ∫ |H̃_G|² dβ, that each step makes; see
docs/theory/fe-be.md.
"""

import sys

import numpy as np

from railvib import library
from railvib.fe_be.model import fe_be_response
from railvib.numerics.wavenumber_panels import WEIGHT, nodes_between
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track

FREQUENCIES = (2.0, 5.0, 10.0, 16.0, 20.0, 31.5, 40.0, 63.0, 80.0, 100.0)
OFFSETS = (8.0, 32.0)
MESH = {"elements": 4, "rows": 2}
"""Within 0.1 dB of the verification study's mesh."""
FIRST = CrossSection(bed="columns", contact="smooth", displacement="centre", elements=1)
STEPS = {
    "average for centre": CrossSection(bed="columns", contact="smooth", elements=1),
    "rigid sleeper": CrossSection(bed="columns", contact="smooth", elements=4),
    "continuous ballast": CrossSection(contact="smooth", poisson_ratio=0.0, **MESH),
    "horizontal tractions": CrossSection(poisson_ratio=0.0, **MESH),
    "Poisson's ratio 0.2": CrossSection(**MESH),
}


def levels(ground: Ground, track: Track, section: CrossSection, frequency: float) -> np.ndarray:
    """Return the levels in dB of the rail under the load, and of the ground at each offset."""
    waves = np.array([0.2, 0.4, 0.6, 0.75, 0.85, 0.92, 0.96, 1.0, 1.05, 1.15, 1.4, 2.0, 3.0])
    edge = np.concatenate([[0.0], 2.0 * np.pi * frequency / ground.slowest_speed * waves])
    edge = np.unique([*edge, *np.geomspace(max(edge[-1], 0.5), 20.0, 6)])
    edge = edge[edge <= 20.0]
    beta, weight = nodes_between(edge), (0.5 * np.diff(edge)[:, None] * WEIGHT).ravel()
    found = fe_be_response(ground, track, section, frequency, beta, OFFSETS)
    return np.array(
        [20.0 * np.log10(abs(found.rail @ weight)), *10.0 * np.log10(abs(found.ground) ** 2 @ weight)]
    )


def main(soils: list[str]) -> None:
    """Print a table per soil and receiver: what each step adds, and their sum."""
    track = library.load("track", "ballasted-paper")
    for soil in soils:
        ground = library.load("soil", soil)
        level = np.array(
            [
                [levels(ground, track, section, frequency) for frequency in FREQUENCIES]
                for section in (FIRST, *STEPS.values())
            ]
        )
        change = np.concatenate([np.diff(level, axis=0), level[-1:] - level[:1]])
        for column, name in enumerate(("rail", *(f"ground, {offset:g} m" for offset in OFFSETS))):
            print(f"\n| {soil}, {name}, Hz | " + " | ".join(f"{each:g}" for each in FREQUENCIES) + " |")
            print("|" + " --- |" * (len(FREQUENCIES) + 1))
            for row, step in enumerate((*STEPS, "together")):
                print(f"| {step} | " + " | ".join(f"{each:.1f}" for each in change[row, :, column]) + " |")


if __name__ == "__main__":
    main(sys.argv[1:] or ["horstwalde", "greby"])
