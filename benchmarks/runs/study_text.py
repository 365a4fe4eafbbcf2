"""Study files for the benchmark, written from their varying keys."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

PAPER_SOILS = ("horstwalde", "greby")


def study(
    *,
    bands_hz: tuple[float, float],
    offsets_m: Sequence[float],
    soils: Sequence[str] = ("greby",),
    trains: Sequence[str] = ("grona-taget",),
    speeds_kmh: Sequence[float] = (150.0,),
    definitions: Mapping[str, Mapping[str, Any]] | None = None,
) -> str:
    """Return the text of a study of the paper's approaches, track and unevenness.

    Parameters
    ----------
    bands_hz
        Lowest and highest midband, Hz.
    offsets_m
        Offsets of the receivers, m.
    soils, trains
        Names from the library or the definitions.
    speeds_kmh
        Speeds, km/h.
    definitions
        Tables by their headings, such as ``soil.soft``.
    """
    tables: dict[str, Mapping[str, Any]] = {
        "study": {"name": "benchmark"},
        "frequency": {"minimum_hz": bands_hz[0], "maximum_hz": bands_hz[1]},
        "receivers": {"rail": True, "offsets_m": [*offsets_m]},
        "approaches": {
            "compare": ["moving-roughness", "moving-roughness-uncorrelated", "full"],
            "reference": "full",
        },
        "sweep": {
            "soil": [*soils],
            "track": ["ballasted-paper"],
            "train": [*trains],
            "unevenness": ["fra-hamid-yang-3"],
            "speed_kmh": [*speeds_kmh],
        },
        **(definitions or {}),
    }
    return "\n".join(
        f"[{heading}]\n" + "".join(f"{key} = {_value(value)}\n" for key, value in table.items())
        for heading, table in tables.items()
    )


def _value(value: Any) -> str:
    """Return a value as TOML: strings, numbers, lists and inline tables."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(_value(inner) for inner in value) + "]"
    return json.dumps(value)
