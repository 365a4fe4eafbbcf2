"""Ground-borne vibration from railway trains: two ways to its power spectral density, compared."""

import importlib
from typing import TYPE_CHECKING, Any

MODEL_VERSION = "4"
"""Version of the physics: enters the identity of all that is computed; grows when a number could change."""

if TYPE_CHECKING:
    from railvib.compliance import ground_green_function, line_compliance
    from railvib.errors import InputError, PlausibilityWarning
    from railvib.flexibility import ground_flexibility
    from railvib.flexibility_tensor import ground_flexibility_tensor
    from railvib.ground import Ground, Layer
    from railvib.prediction import predict, rail_receptance
    from railvib.surface_waves import critical_speed, surface_wave_speeds
    from railvib.track import Track, TrackLayer
    from railvib.unevenness import Unevenness
    from railvib.vehicle import Train, Vehicle

_HOME = {
    "Ground": "ground",
    "InputError": "errors",
    "Layer": "ground",
    "PlausibilityWarning": "errors",
    "Track": "track",
    "TrackLayer": "track",
    "Train": "vehicle",
    "Unevenness": "unevenness",
    "Vehicle": "vehicle",
    "critical_speed": "surface_waves",
    "ground_flexibility": "flexibility",
    "ground_flexibility_tensor": "flexibility_tensor",
    "ground_green_function": "compliance",
    "line_compliance": "compliance",
    "predict": "prediction",
    "rail_receptance": "prediction",
    "surface_wave_speeds": "surface_waves",
}

__all__ = [
    "MODEL_VERSION",
    "Ground",
    "InputError",
    "Layer",
    "PlausibilityWarning",
    "Track",
    "TrackLayer",
    "Train",
    "Unevenness",
    "Vehicle",
    "critical_speed",
    "ground_flexibility",
    "ground_flexibility_tensor",
    "ground_green_function",
    "line_compliance",
    "predict",
    "rail_receptance",
    "surface_wave_speeds",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: the compiled kernels take a second to load."""
    if name not in _HOME:
        raise AttributeError(f"module 'railvib' has no attribute {name!r}")
    return getattr(importlib.import_module(f"railvib.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
