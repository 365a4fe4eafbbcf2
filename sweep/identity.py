"""Identity by content: what is computed from the same physical inputs by the same model is the same thing.

An id is the sha256 of a canonical JSON text, in which a table stands as its own id: so what many units share,
such as a ground, is written out once. Numbers are written as floats by `repr`, so 150 and 150.0 agree;
keys are sorted; names, paths, the order of axes and the number of workers never enter, because callers put
physics in only.
"""

import hashlib
import json
import math
from collections.abc import Mapping
from functools import cached_property, lru_cache
from json.encoder import encode_basestring
from typing import Any

from pydantic import BaseModel

import railvib
from railvib.parameters.receiver import Receiver

_EXACT_INTEGERS = 2**53
FLOATS = frozenset({float})
NUMBERS = frozenset({float, int})
REMEMBERED = 4096
"""Tuples of numbers, such as bands and distances of axles, that many units share."""


class Canonical(dict[str, Any]):
    """A table in canonical form; it knows its own digest, and is never changed."""

    @cached_property
    def digest(self) -> str:
        """The sha256 of the table, in hexadecimal."""
        lines = ",".join(f"{encode_basestring(key)}:{_short_text(self[key])}" for key in sorted(self))
        return hashlib.sha256(f"{{{lines}}}".encode()).hexdigest()

    def __hash__(self) -> int:  # type: ignore[override]
        """Return the hash of the digest, so that results derived from a table can be cached."""
        return hash(self.digest)


def canonical(value: Any) -> Any:
    """Return the canonical form of `value`, plain JSON data: models by field name, numbers as floats.

    Raises
    ------
    ValueError
        If a number is not finite, or an integer too large to be a float exactly.
    TypeError
        If something has no canonical form, such as an array or a path.
    """
    kind = type(value)  # first what is frequent: a plan writes out a million numbers
    if kind is Canonical:
        return value
    if kind is tuple:
        return _canonical_numbers(value) if _are(NUMBERS, value) else tuple(map(canonical, value))
    if isinstance(value, BaseModel):
        return _canonical_model(value)
    if isinstance(value, Receiver):
        return canonical(value.key)
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, int):
        if abs(value) > _EXACT_INTEGERS:
            raise ValueError(f"{value} is too large an integer for an identity")
        return float(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} cannot be part of an identity")
        return float(value) + 0.0  # -0.0 becomes 0.0
    if isinstance(value, Mapping):
        return Canonical({str(key): canonical(item) for key, item in value.items()})
    if isinstance(value, list | tuple):
        return canonical(tuple(value))
    if isinstance(value, set | frozenset):
        return tuple(sorted((canonical(item) for item in value), key=text))
    raise TypeError(f"{type(value).__name__} has no canonical form")


def _are(types: frozenset[type], values: tuple[Any, ...]) -> bool:
    """Return whether all values are of these types: a boolean equals a number, and is written otherwise."""
    return types.issuperset(map(type, values))


@lru_cache(REMEMBERED)
def _canonical_numbers(numbers: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(map(canonical, numbers))


@lru_cache(REMEMBERED)
def _text_of_numbers(numbers: tuple[float, ...]) -> str:
    return _json(numbers)


def _short_text(value: Any) -> str:
    """Return the text of what is in canonical form; a table stands as its id."""
    if type(value) is Canonical:
        return f'"{value.digest}"'
    if type(value) is tuple and _are(FLOATS, value):
        return _text_of_numbers(value)
    return _json(value)


@lru_cache(1024)
def _canonical_model(model: BaseModel) -> Canonical:
    """Return the canonical form of a frozen model, which many units share.

    By hand, not by model_dump(): it leaves out aliases with units and absent values, so that a new optional
    field does not change the ids of objects without it.
    """
    fields = {name: getattr(model, name) for name in type(model).model_fields}
    return Canonical({name: canonical(item) for name, item in fields.items() if item is not None})


def text(value: Any) -> str:
    """Return the canonical JSON text of `value`, written out in full."""
    return _json(canonical(value))


def digest(value: Mapping[str, Any]) -> str:
    """Return the sha256 of a table's canonical form, in hexadecimal."""
    table: Canonical = canonical(value)
    return table.digest


def unit_id(stage: str, inputs: Mapping[str, Any]) -> str:
    """Return the id of a stored unit: its stage, its physical inputs and the model's own version number."""
    return digest({"kind": stage, "model_version": railvib.MODEL_VERSION, "inputs": inputs})


def case_id(things: Mapping[str, Any], speed: float) -> str:
    """Return the id of a case: its physics alone, whatever computes it.

    Parameters
    ----------
    things
        Ground, track, train and unevenness by kind.
    speed
        m/s.
    """
    return digest({**things, "speed": speed})


def _json(value: Any) -> str:
    return _ENCODER.encode(value)


_ENCODER = json.JSONEncoder(sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
