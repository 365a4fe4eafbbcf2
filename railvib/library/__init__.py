"""Soils, tracks, vehicles, trains and unevenness with their sources."""

from railvib.library.catalogue import (
    DOCUMENTATION,
    KINDS,
    Definition,
    Definitions,
    Entry,
    Kind,
    build,
    entry,
    load,
    names,
    resolve,
    resolve_train,
)

__all__ = [
    "DOCUMENTATION",
    "KINDS",
    "Definition",
    "Definitions",
    "Entry",
    "Kind",
    "build",
    "entry",
    "load",
    "names",
    "resolve",
    "resolve_train",
]
