"""What the names of a study stand for, as rows: soils, tracks, trains and unevenness with their parts.

Values arrive in the form of a study file, whose keys carry units; the columns of the tables have the same
names, so a new parameter needs a column and nothing here.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

Row = dict[str, Any]
Tables = dict[str, list[Row]]

KINDS = ("soil", "track", "train", "unevenness")


def identity(name: str, definition: Mapping[str, Any]) -> str:
    """Return the id of a named thing: the same name with the same definition has the same id in every run."""
    text = json.dumps([name, definition], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


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
"""Tables of parameters with the columns that tell their rows apart; the first is the id of a named thing."""


def rows(
    parameters: Mapping[str, Mapping[str, Mapping[str, Any]]], rayleigh_speeds: Mapping[str, Sequence[float]]
) -> Tables:
    """Return the rows of all parameter tables for the `parameters` of one manifest.

    Parameters
    ----------
    parameters
        Definitions by kind and name.
    rayleigh_speeds
        Rayleigh speed of each layer's material by soil, m/s, where the run said it.
    """
    tables: Tables = {table: [] for table in TABLES}
    for kind in KINDS:
        for name, definition in parameters.get(kind, {}).items():
            head = {kind: name, f"{kind}_id": identity(name, definition)}
            row = {**definition, **head, "definition": json.dumps(definition, sort_keys=True)}
            if kind == "soil":
                layers = definition.get("layers", [])
                tables["soils"].append(
                    {**row, "layers": len(layers), "base": definition.get("base", "half-space")}
                )
                speeds = rayleigh_speeds.get(name, [None] * len(layers))
                tables["soil_layers"] += [
                    {**layer, "rayleigh_speed_m_s": speed}
                    for layer, speed in zip(_numbered(layers, head), speeds, strict=True)
                ]
            elif kind == "track":
                mat = definition.get("mat")
                tables["tracks"].append({**row, "form": definition.get("form", "ballasted")})
                tables["track_layers"] += _numbered([mat], head, first=0) if mat else []
                tables["track_layers"] += _numbered(definition.get("layers", []), head)
            elif kind == "train":
                vehicles = definition.get("vehicles", [])
                axles = list(_axles(vehicles, head))
                length = sum(vehicle["length_m"] for vehicle in vehicles)
                tables["trains"].append(
                    {**row, "vehicles": len(vehicles), "axles": len(axles), "length_m": length}
                )
                tables["vehicles"] += _numbered(vehicles, head, column="vehicle")
                tables["axles"] += axles
            else:
                tables["unevenness"].append(row)
    return tables


def _numbered(
    parts: Iterable[Mapping[str, Any]], head: Row, column: str = "layer", first: int = 1
) -> list[Row]:
    return [{**part, **head, column: number} for number, part in enumerate(parts, first)]


def _axles(vehicles: Iterable[Mapping[str, Any]], head: Row) -> Iterable[Row]:
    """Yield the axles from the head of the train, where the first vehicle is."""
    front = 0.0
    places = []
    for number, vehicle in enumerate(vehicles, 1):
        for bogie in (-1, 1):
            for axle in (-1, 1):
                middle = front + vehicle["length_m"] / 2
                place = middle + bogie * vehicle["bogie_spacing_m"] / 2 + axle * vehicle["axle_spacing_m"] / 2
                places.append((number, place, vehicle.get("axle_load_n")))
        front += vehicle["length_m"]
    for number, (vehicle_number, place, load) in enumerate(places, 1):
        yield {
            **head,
            "receiver": f"axle-{number}",
            "vehicle": vehicle_number,
            "behind_first_axle_m": place - places[0][1],
            "axle_load_n": load,
        }
