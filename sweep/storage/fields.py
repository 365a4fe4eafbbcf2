"""The fields of a result, a frozen dataclass, as arrays and attributes that a group can hold, and back.

Fields whose metadata name their dimensions are arrays, `field(metadata={"dims": ("frequency", "node"),
"unit": "m/N", "description": "..."})`; all others, and arrays of text, are attributes. With "called_by" an
array takes its name from another field: H of the rail is stored as `rail`. A field with "shared_by" refers to
a dataclass that several results share, which is stored once for all of them; its metadata name the dimension
along which the results lie then. What is shared may refer to further shared dataclasses; all of them can be
hashed.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, TypeVar
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

Result = TypeVar("Result")

Arrays = dict[str, tuple[NDArray[Any], Mapping[str, Any]]]
"""Arrays with their metadata, by name."""
Recorded = Mapping[str, Mapping[str, Any]]
"""What a record holds of the arrays of a group: sha256, shape and dtype by their names."""


class Part(NamedTuple):
    """Arrays and attributes of a dataclass, without those of what it shares with others."""

    source: Any
    arrays: Arrays
    attributes: dict[str, Any]


class Parts(NamedTuple):
    """The parts of a result: its own, and those that it shares with other results."""

    member: Part
    """Its own part, in which the members of a group differ."""
    shared: tuple[Part, ...]
    dimension: str | None
    """Dimension along which results that share the rest are stacked; None if nothing is shared."""

    def with_attributes(self, **attributes: Any) -> "Parts":
        """Return the parts with further attributes of the result's own."""
        return self._replace(member=self.member._replace(attributes=self.member.attributes | attributes))

    @property
    def shared_attributes(self) -> dict[str, Any]:
        """Attributes of what is shared."""
        return {name: value for part in self.shared for name, value in part.attributes.items()}

    @property
    def attributes(self) -> dict[str, Any]:
        """All attributes."""
        return self.shared_attributes | self.member.attributes

    @property
    def arrays(self) -> Arrays:
        """All arrays."""
        return {name: array for part in (*self.shared, self.member) for name, array in part.arrays.items()}

    @property
    def group_key(self) -> tuple[Any, ...]:
        """Key that is equal for results that can be stored in one group."""
        form = [(name, array.shape, array.dtype) for name, (array, _) in self.member.arrays.items()]
        return tuple(part.source for part in self.shared), tuple(form)


def split(result: Any) -> Parts:
    """Split the fields of a dataclass into arrays with their metadata and attributes; check dimensions."""
    member, *shared = _split(result, {})
    dimensions = filter(None, map(_dimension, dataclasses.fields(result)))
    return Parts(member, tuple(shared), next(dimensions, None))


def _split(result: Any, sizes: dict[str, int]) -> Iterator[Part]:
    """Yield the parts of a dataclass, first its own, then what it shares; check sizes along dimensions."""
    part = Part(result, {}, {})
    yield part
    for field in dataclasses.fields(result):
        value = getattr(result, field.name)
        if _dimension(field):
            yield from _split(value, sizes)
            continue
        if "dims" not in field.metadata:
            part.attributes[field.name] = _plain(value)
            continue
        if value is None:
            continue
        array = np.asarray(value)
        dims = field.metadata["dims"]
        if array.dtype.kind == "U":  # Zarr has no stable format for text
            part.attributes[field.name] = array.tolist()
            continue
        if array.ndim != len(dims) or array.dtype.kind not in "fciub":
            raise ValueError(
                f"{type(result).__name__}.{field.name}: {array.dtype} {array.shape} does not fit {dims}"
            )
        for dim, size in zip(dims, array.shape, strict=True):
            if sizes.setdefault(dim, size) != size:
                raise ValueError(
                    f"{type(result).__name__}.{field.name}: {size} along {dim}, others have {sizes[dim]}"
                )
        part.arrays[_stored_name(field, lambda name: getattr(result, name))] = (array, field.metadata)


_in_memory: "WeakValueDictionary[tuple[Any, ...], Any]" = WeakValueDictionary()
"""Shared parts by type and content, as long as a result that refers to them is in memory."""


def restore(
    result_type: type[Result],
    arrays: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
    recorded: Recorded | None = None,
) -> Result:
    """Return the dataclass whose arrays and attributes were stored.

    A shared part is one object for all results in memory whose records agree in it.
    """
    values: dict[str, Any] = {}
    for field in dataclasses.fields(result_type):  # type: ignore[arg-type]
        if _dimension(field):
            values[field.name] = _restore_shared(field.type, arrays, attributes, recorded)
        elif "dims" in field.metadata:
            name = _stored_name(field, attributes.__getitem__)
            array = np.asarray(attributes[name]) if name in attributes else arrays.get(name)
            values[field.name] = array[()] if array is not None and array.ndim == 0 else array
        else:
            values[field.name] = _restore_value(attributes[field.name], field.type)
    return result_type(**values)


def _restore_shared(
    result_type: Any,
    arrays: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
    recorded: Recorded | None,
) -> Any:
    """Return a shared part: the object in memory if one has the same content."""
    if recorded is None:
        return restore(result_type, arrays, attributes)
    key = result_type, *_content(result_type, attributes, recorded)
    part = _in_memory.get(key)
    if part is None:
        part = _in_memory[key] = restore(result_type, arrays, attributes, recorded)
    return part


def _content(result_type: Any, attributes: Mapping[str, Any], recorded: Recorded) -> Iterator[Any]:
    """Yield the content of a dataclass: checksums of its arrays, and its attributes as text."""
    for field in dataclasses.fields(result_type):
        if _dimension(field):
            yield from _content(field.type, attributes, recorded)
        elif field.name in recorded:
            array = recorded[field.name]
            yield array["sha256"], array["dtype"], tuple(array["shape"])
        else:
            yield repr(attributes.get(field.name))


def _dimension(field: "dataclasses.Field[Any]") -> str | None:
    """Return the dimension along which results that share this field are stacked, or None."""
    return field.metadata.get("shared_by")


def _stored_name(field: "dataclasses.Field[Any]", attribute: Callable[[str], Any]) -> str:
    """Return an array's name in the store: that of its field, or what `called_by` refers to."""
    return str(attribute(field.metadata["called_by"])) if "called_by" in field.metadata else field.name


def _plain(value: Any) -> Any:
    """Return an attribute in plain JSON: complex numbers as pairs, NaN and infinity as text."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if not isinstance(value, tuple):
        return value
    if all(type(item) is float for item in value) and math.isfinite(sum(value)):
        return list(value)
    return [_plain(item) for item in value]


def _restore_value(value: Any, form: Any) -> Any:
    """Return an attribute as the dataclass holds it."""
    if form == tuple[float, ...]:
        return tuple(map(float, value))
    if isinstance(value, list):
        value = tuple(_restore_value(item, form) for item in value)
    if form in (complex, "complex"):
        return complex(*map(float, value)) if isinstance(value, tuple) else value
    return float(value) if form in (float, "float") else value
