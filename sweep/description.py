"""What a manifest says of a study's physics, as the results know none."""

from railvib.parameters.ground import Ground
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from sweep.study import Resolved


def unevenness_bands(resolved: Resolved) -> dict[str, list[dict[str, float]]]:
    """Return the one-third octaves over wavelength of every unevenness, as far as the study excites them."""
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
    """Return the Rayleigh speed of each layer's material by soil, m/s; the results know no physics."""
    return {
        name: [layer.rayleigh_speed for layer in ground.layers]
        for name, ground in resolved.objects["soil"].items()
        if isinstance(ground, Ground)
    }
