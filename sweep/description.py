"""Physics that a manifest stores for `queries`, which knows none."""

from typing import Any

from railvib.parameters.ground import Ground
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.parameters.vehicle import Train
from sweep.study import Resolved


def unevenness_bands(resolved: Resolved) -> dict[str, list[dict[str, float]]]:
    """Return the one-third octaves of every unevenness, over the wavelengths that the study excites."""
    study = resolved.study
    speeds = [speed / KMH for speed in study.sweep.speed_kmh]
    shortest, longest = min(speeds) / study.frequency.maximum_hz, max(speeds) / study.frequency.minimum_hz
    return {
        name: [
            {
                "wavelength_m": float(wavelength),
                "mean_square_m2": float(mean_square),
                "extrapolated_share": float(share),
            }
            for wavelength, mean_square, share in zip(
                *unevenness.third_octaves(shortest, longest), strict=True
            )
        ]
        for name, unevenness in resolved.objects["unevenness"].items()
        if isinstance(unevenness, Unevenness)
    }


def rayleigh_speeds(resolved: Resolved) -> dict[str, list[float]]:
    """Return the Rayleigh speed of each layer's material by soil, m/s."""
    return {
        name: [layer.rayleigh_speed for layer in ground.layers]
        for name, ground in resolved.objects["soil"].items()
        if isinstance(ground, Ground)
    }


def axles(resolved: Resolved) -> dict[str, list[dict[str, Any]]]:
    """Return the axles of every train, the leading one first, with vehicle, place and static load."""
    return {
        name: [
            {
                "receiver": f"axle-{number}",
                "vehicle": int(vehicle),
                "behind_first_axle_m": float(train.axle_positions[-1] - position),
                "axle_load_n": float(load),
            }
            for number, (vehicle, position, load) in enumerate(
                zip(
                    train.axle_vehicles[::-1],
                    train.axle_positions[::-1],
                    train.axle_loads[::-1],
                    strict=True,
                ),
                1,
            )
        ]
        for name, train in resolved.objects["train"].items()
        if isinstance(train, Train)
    }
