"""What a track that follows the ground's mean displacement changes, and on which side the FE/BE model lies.

    .venv/bin/python studies/coupling.py [SOIL …]

prints, for the paper's track, levels in dB over those of the coupling at the centre: of the rail's receptance
under the load, and of the ground's mean square along the line per unit load, ∫ |H̃_G|² dβ; see
docs/theory/track-and-forces.md.
"""

import sys
from collections.abc import Callable

import numpy as np

from railvib import library
from railvib.fe_be.model import fe_be_response
from railvib.numerics.wavenumber_panels import WEIGHT, nodes_between
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.soil.rational_fit import fit_flexibility
from railvib.soil.strip import mean_fit_reach, strip_compliance
from railvib.transfer.compliance_under_track import compliance_under_track
from railvib.transfer.track_response import track_response

FREQUENCIES = (2.0, 5.0, 10.0, 16.0, 20.0, 31.5, 40.0, 63.0, 80.0, 100.0)
OFFSETS = (8.0, 32.0)

Responses = Callable[[Ground, Track, float, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Returns H̃_R and H̃_G at the offsets, at a frequency in Hz and wavenumbers in rad/m."""


def semi_analytical(
    ground: Ground, track: Track, frequency: float, beta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the responses of the semi-analytical model."""
    fit = fit_flexibility(ground, frequency, 1e-10, largest=mean_fit_reach(track.half_width))
    under = compliance_under_track(fit, beta, track)
    rail, force = track_response(track, beta, 2.0 * np.pi * frequency, under)
    return rail, force * strip_compliance(fit, beta, track.half_width, np.array(OFFSETS))


def verification(
    ground: Ground, track: Track, frequency: float, beta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the responses of the FE/BE model."""
    section = CrossSection(elements=4, rows=2)
    response = fe_be_response(ground, track, section, frequency, beta, OFFSETS)
    return response.rail, response.ground


def levels(responses: Responses, ground: Ground, track: Track, frequency: float) -> np.ndarray:
    """Return the levels in dB of the rail under the load, and of the ground at each offset."""
    waves = np.array([0.2, 0.4, 0.6, 0.75, 0.85, 0.92, 0.96, 1.0, 1.05, 1.15, 1.4, 2.0, 3.0])
    edge = np.concatenate([[0.0], 2.0 * np.pi * frequency / ground.slowest_speed * waves])
    edge = np.unique([*edge, *np.geomspace(max(edge[-1], 0.5), 20.0, 6)])
    edge = edge[edge <= 20.0]
    beta, weight = nodes_between(edge), (0.5 * np.diff(edge)[:, None] * WEIGHT).ravel()
    rail, field = responses(ground, track, frequency, beta)
    return np.array([20.0 * np.log10(abs(rail @ weight)), *10.0 * np.log10(abs(field) ** 2 @ weight)])


def differences(soil: str, frequency: float) -> np.ndarray:
    """Return levels of the mean and of the FE/BE model over those of the centre, dB, (2, receivers)."""
    ground, centre = library.load("soil", soil), library.load("track", "ballasted-paper")
    mean = centre.model_copy(update={"coupling": "mean"})
    reference = levels(semi_analytical, ground, centre, frequency)
    others = (
        levels(semi_analytical, ground, mean, frequency),
        levels(verification, ground, centre, frequency),
    )
    return np.array(others) - reference


def main(soils: list[str]) -> None:
    """Print a table per soil."""
    receivers = ("rail", *(f"ground {offset:g} m" for offset in OFFSETS))
    for soil in soils:
        table = np.array([differences(soil, frequency) for frequency in FREQUENCIES])
        print(f"\n| {soil}, Hz | " + " | ".join(f"{each:g}" for each in FREQUENCIES) + " |")
        print("|" + " --- |" * (len(FREQUENCIES) + 1))
        for column, receiver in enumerate(receivers):
            for row, name in enumerate(("`mean`", "`fe-be`")):
                cells = (f"{value:.1f}" for value in table[:, row, column].round(1) + 0.0)
                print(f"| {receiver}, {name} | " + " | ".join(cells).replace("-", "−") + " |")


if __name__ == "__main__":
    main(sys.argv[1:] or ["horstwalde", "greby"])
