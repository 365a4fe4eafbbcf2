"""Ground-borne vibration from railway trains: two ways to its power spectral density, compared."""

import importlib
from typing import TYPE_CHECKING, Any

MODEL_VERSION = "5"
"""Version of the physics: enters the identity of all that is computed; grows when a number could change."""

if TYPE_CHECKING:
    from railvib.errors import InputError, PlausibilityWarning
    from railvib.parameters.ground import Ground, Layer
    from railvib.parameters.track import Track, TrackLayer
    from railvib.parameters.unevenness import Unevenness
    from railvib.parameters.vehicle import Train, Vehicle
    from railvib.prediction import predict, predict_passage, rail_receptance
    from railvib.soil.compliance import ground_green_function, line_compliance
    from railvib.soil.flexibility import ground_flexibility
    from railvib.soil.flexibility_tensor import ground_flexibility_tensor
    from railvib.soil.surface_waves import surface_wave_speeds
    from railvib.transfer.critical_speed import critical_speed

_HOME = {
    "Ground": "parameters.ground",
    "InputError": "errors",
    "Layer": "parameters.ground",
    "PlausibilityWarning": "errors",
    "Track": "parameters.track",
    "TrackLayer": "parameters.track",
    "Train": "parameters.vehicle",
    "Unevenness": "parameters.unevenness",
    "Vehicle": "parameters.vehicle",
    "critical_speed": "transfer.critical_speed",
    "ground_flexibility": "soil.flexibility",
    "ground_flexibility_tensor": "soil.flexibility_tensor",
    "ground_green_function": "soil.compliance",
    "line_compliance": "soil.compliance",
    "predict": "prediction",
    "predict_passage": "prediction",
    "rail_receptance": "prediction",
    "surface_wave_speeds": "soil.surface_waves",
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
    "predict_passage",
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
