"""Writes dispersion_modes.csv: Rayleigh modes of the models in dispersion_models.csv by disba 0.7.

rayleigh_love_greby.csv holds Rayleigh and Love modes of the layering of Greby, on which disba 0.7.0 and a
fast-delta code of another project agree to 1e-6. It is recomputed, and the largest difference is printed.

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


GREBY = ((2.0, 193.37, 103.36, 1800.0), (2.0, 228.80, 122.30, 1800.0), (0.0, 580.12, 310.09, 2000.0))
"""Thickness, dilatational and shear speed, density of the layers, SI."""


def layers(model: str) -> np.ndarray:
    """Return thickness, dilatational speed, shear speed in km and km/s, density in g/cm³, by layer."""
    with (DATA / "dispersion_models.csv").open(encoding="utf-8", newline="") as file:
        rows = [
            row for row in csv.DictReader(line for line in file if line[0] != "#") if row["model"] == model
        ]
    names = "thickness_m", "dilatational_speed_m_s", "shear_speed_m_s", "density_kg_m3"
    return np.array([[float(row[name] or 0.0) / 1000.0 for name in names] for row in rows])


def write_models() -> None:
    """Compute the modes of the models and write them."""
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


def greby_difference() -> float:
    """Return the largest difference of the modes of Greby from rayleigh_love_greby.csv, m/s."""
    dispersion = PhaseDispersion(*(np.array(GREBY) / 1000.0).T, algorithm="dunkin", dc=0.0005)
    differences = []
    with (DATA / "rayleigh_love_greby.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(line for line in file if line[0] != "#"):
            wave = {"R": "rayleigh", "L": "love"}[row["mode"][0]]
            period = np.array([1.0 / float(row["frequency_hz"])])
            curve = dispersion(period, mode=int(row["mode"][1:]), wave=wave)
            differences.append(abs(1000.0 * curve.velocity[0] - float(row["phase_speed_m_s"])))
    return max(differences)


if __name__ == "__main__":
    write_models()
    print(f"rayleigh_love_greby.csv: {greby_difference():.4f} m/s")
