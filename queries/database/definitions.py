"""Definitions of a study's names as rows: soils, tracks, trains and unevenness with their parts.

Values arrive in the form of a study file, whose keys carry units; the columns of the tables have the same
names, so a new parameter needs a column and nothing here.
"""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

Row = dict[str, Any]
Tables = dict[str, list[Row]]

KINDS = ("soil", "track", "train", "unevenness")

TABLES = {
    "soils": ("soil_id",),
    "soil_layers": ("soil_id", "layer"),
    "tracks": ("track_id",),
    "track_layers": ("track_id", "layer"),
    "trains": ("train_id",),
    "vehicles": ("train_id", "vehicle"),
    "axles": ("train_id", "receiver"),
    "unevenness": ("unevenness_id",),
}
"""Tables with their key columns; the first is the id of the definition."""

_AXLES_PER_VEHICLE = 4


def identity(name: str, definition: Mapping[str, Any]) -> str:
    """Return the id of a name with its definition; it is the same in every run."""
    text = json.dumps([name, definition], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def identities(manifest: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Return the ids of all definitions of a manifest, by kind and name."""
    parameters = manifest.get("parameters", {})
    return {
        kind: {name: identity(name, definition) for name, definition in parameters.get(kind, {}).items()}
        for kind in KINDS
    }


def rows(manifest: Mapping[str, Any]) -> Tables:
    """Return the rows of all tables of definitions for one manifest."""
    tables: Tables = {table: [] for table in TABLES}
    ids = identities(manifest)
    for kind in KINDS:
        for name, definition in manifest.get("parameters", {}).get(kind, {}).items():
            head = {kind: name, f"{kind}_id": ids[kind][name]}
            row = {**definition, **head, "definition": json.dumps(definition, sort_keys=True)}
            if kind == "soil":
                speeds = manifest.get("rayleigh_speeds_m_s", {}).get(name)
                _add_soil(tables, row, head, definition, speeds)
            elif kind == "track":
                _add_track(tables, row, head, definition)
            elif kind == "train":
                _add_train(tables, row, head, definition, manifest.get("axles", {}).get(name))
            else:
                tables["unevenness"].append(row)
    return tables


def _add_soil(
    tables: Tables, row: Row, head: Row, definition: Mapping[str, Any], rayleigh_speeds: Iterable[Any] | None
) -> None:
    layers = definition.get("layers", [])
    base = definition.get("base", "half-space")
    tables["soils"].append({**row, "layers": len(layers), "base": base})
    speeds = rayleigh_speeds or [None] * len(layers)  # older manifests hold none
    tables["soil_layers"] += [
        {**layer, "rayleigh_speed_m_s": speed}
        for layer, speed in zip(_number_parts(layers, head, "layer"), speeds, strict=True)
    ]


def _add_track(tables: Tables, row: Row, head: Row, definition: Mapping[str, Any]) -> None:
    mat = definition.get("mat")
    tables["tracks"].append({**row, "form": definition.get("form", "ballasted")})
    tables["track_layers"] += _number_parts([mat], head, "layer", first=0) if mat else []
    tables["track_layers"] += _number_parts(definition.get("layers", []), head, "layer")


def _add_train(
    tables: Tables, row: Row, head: Row, definition: Mapping[str, Any], axles: Iterable[Row] | None
) -> None:
    vehicles = definition.get("vehicles", [])
    placed = list(_axles_without_places(vehicles) if axles is None else axles)
    length = sum(vehicle["length_m"] for vehicle in vehicles)
    tables["trains"].append({**row, "vehicles": len(vehicles), "axles": len(placed), "length_m": length})
    tables["vehicles"] += _number_parts(map(_with_car, vehicles), head, "vehicle")
    tables["axles"] += [{**axle, **head} for axle in placed]


def _with_car(vehicle: Mapping[str, Any]) -> Row:
    """Return a vehicle with the columns of its car, which one given by its parts has in a table."""
    return {**vehicle, **{f"car_{key}": value for key, value in vehicle.get("car", {}).items()}}


def _axles_without_places(vehicles: Iterable[Mapping[str, Any]]) -> Iterator[Row]:
    """Yield the axles of a train from its head, for older manifests, which lack their positions."""
    loads = [
        (number, vehicle.get("axle_load_n"))
        for number, vehicle in enumerate(vehicles, 1)
        for _ in range(_AXLES_PER_VEHICLE)
    ]
    for axle, (vehicle_number, load) in enumerate(loads, 1):
        yield {"receiver": f"axle-{axle}", "vehicle": vehicle_number, "axle_load_n": load}


def _number_parts(parts: Iterable[Mapping[str, Any]], head: Row, column: str, first: int = 1) -> list[Row]:
    return [{**part, **head, column: number} for number, part in enumerate(parts, first)]
