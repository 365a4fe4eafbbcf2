"""Writes dispersion_modes.csv: Rayleigh modes of the models in dispersion_models.csv by disba 0.7.

Run from the top of the repository, where disba is installed (the project does not need it):
``python -m tests.data.dispersion``.
"""

import csv
from pathlib import Path

import numpy as np
from disba import PhaseDispersion

DATA = Path(__file__).parent
FREQUENCIES = {
    "disba-38": (5, 8, 10, 12.5, 15, 20, 30, 40, 60),
    "disba-20": (1, 2, 5, 10, 16, 20, 31.5, 50, 80, 100),
    "disba-32": (5, 10, 16, 20, 31.5, 40, 50, 63, 80, 100),
    "pysurf96-2-300": (1, 2, 3, 4, 5, 6),
    "pysurf96-2-301": (1, 2, 3, 4, 5, 6),
}
OVERTONES = {("disba-20", 100): 9, **{("disba-32", f): 1 for f in FREQUENCIES["disba-32"]}}
"""Highest mode wanted beside the fundamental."""
HEADER = """\
# Phase speeds [m/s] of the Rayleigh modes of the undamped models of dispersion_models.csv, mode 0 the
# fundamental. Source: disba 0.7 (dunkin) by dispersion.py; fundamentals and overtones agree with PyGRT 0.18
# where both ran, to 0.005 m/s.
"""


def layers(model: str) -> np.ndarray:
    """Return thickness, dilatational speed, shear speed in km and km/s, density in g/cm³, by layer."""
    with (DATA / "dispersion_models.csv").open(encoding="utf-8", newline="") as file:
        rows = [
            row for row in csv.DictReader(line for line in file if line[0] != "#") if row["model"] == model
        ]
    names = "thickness_m", "dilatational_speed_m_s", "shear_speed_m_s", "density_kg_m3"
    return np.array([[float(row[name] or 0.0) / 1000.0 for name in names] for row in rows])


def main() -> None:
    """Compute all modes and write them."""
    with (DATA / "dispersion_modes.csv").open("w", encoding="utf-8", newline="") as file:
        file.write(HEADER)
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["model", "frequency_hz", "mode", "speed_m_s"])
        for model, frequencies in FREQUENCIES.items():
            dispersion = PhaseDispersion(*layers(model).T, algorithm="dunkin", dc=0.0005)
            for frequency in frequencies:
                for mode in range(OVERTONES.get((model, frequency), 0) + 1):
                    curve = dispersion(np.array([1.0 / frequency]), mode=mode, wave="rayleigh")
                    table.writerow([model, frequency, mode, f"{1000.0 * curve.velocity[0]:.3f}"])


if __name__ == "__main__":
    main()
