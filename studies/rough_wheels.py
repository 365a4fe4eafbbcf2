"""What wheels out of round do to the coherence between axles: the paper's case with smooth and rough wheels.

    .venv/bin/python studies/rough_wheels.py

prints, per one-third octave of the paper's case on Greby at 150 km/h, which share of the dynamic mean square
comes from the wheels, and by how many decibels correlated moving roughness exceeds uncorrelated one; see
docs/theory/spectra.md.
"""

import numpy as np

from railvib import library, predict
from railvib.parameters.units import KMH
from railvib.parameters.vehicle import Train
from railvib.parameters.wheel_roughness import WheelRoughness

ORDERS = tuple(26.0 - 20.0 * float(np.log10(order)) for order in range(1, 31))
"""dB re 1e-6 m: 20 µm at the first order, falling by 6 dB per doubling; assumed, not measured."""
FIRST, LAST = 8.0, 100.0
APPROACHES = ("moving-roughness", "moving-roughness-uncorrelated", "full")


def main() -> None:
    """Print the table."""
    smooth = library.load("train", "grona-taget")
    roughness = WheelRoughness(form="orders", order_level=ORDERS)
    rough = Train(
        vehicles=tuple(each.model_copy(update={"wheel_roughness": roughness}) for each in smooth.vehicles)
    )
    results = [
        predict(
            library.load("soil", "greby"),
            library.load("track", "ballasted-paper"),
            train,
            library.load("unevenness", "fra-hamid-yang-3"),
            150.0 / KMH,
            [8.0],
            approaches=APPROACHES,
            minimum_frequency=FIRST,
            maximum_frequency=LAST,
        )
        for train in (smooth, rough)
    ]
    ground = [result.velocity_mean_square.sel(receiver="ground 8 m") for result in results]
    rows = {}
    for approach in ("moving-roughness", "full"):
        values = ground[1].sel(approach=approach)
        share = values.sel(contribution="wheels") / values.sel(contribution="dynamic")
        rows[f"share of the wheels, {approach}"] = [f"{100.0 * float(each):.0f} %" for each in share]
    for name, result, values in zip(("smooth", "rough"), results, ground, strict=True):
        second = result.force_mean_square.sel(axle=2)
        for place, energy in (
            ("force, second axle", second),
            ("ground, 8 m", values.sel(contribution="dynamic")),
        ):
            effect = 10.0 * np.log10(energy.sel(approach=APPROACHES[0]) / energy.sel(approach=APPROACHES[1]))
            cells = [f"{each:.1f}".replace("-", "−") for each in effect.values.round(1) + 0.0]
            rows[f"correlated − uncorrelated, {place}, {name} wheels"] = cells
    bands = [f"{band:.3g}" for band in results[0].band.values]
    print("| Hz | " + " | ".join(bands) + " |")
    print("|" + " --- |" * (len(bands) + 1))
    for label, cells in rows.items():
        print(f"| {label} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
