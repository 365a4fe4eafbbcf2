"""Soils, tracks, vehicles, trains and unevenness with their sources."""

from railvib.library.catalogue import DOCUMENTATION, KINDS, Entry, Kind, entry, names
from railvib.library.definitions import (
    MODELS,
    Definition,
    Definitions,
    build,
    load,
    model,
    resolve,
    resolve_train,
)

__all__ = [
    "DOCUMENTATION",
    "KINDS",
    "MODELS",
    "Definition",
    "Definitions",
    "Entry",
    "Kind",
    "build",
    "entry",
    "load",
    "model",
    "names",
    "resolve",
    "resolve_train",
]
