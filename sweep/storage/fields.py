"""The fields of a result, a frozen dataclass, as arrays and attributes that a group can hold, and back.

Fields whose metadata name their dimensions are arrays, `field(metadata={"dims": ("frequency", "node"),
"unit": "m/N", "description": "..."})`; all others, and arrays of text, are attributes. With "called_by" an
array takes its name from another field: H of the rail is stored as `rail`. In fields with "own" results
differ that have all other arrays in common; it names the dimension along which their arrays then lie.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

Result = TypeVar("Result")


Arrays = dict[str, tuple[NDArray[Any], Mapping[str, Any]]]
"""Arrays with their metadata, by name."""


class Parts(NamedTuple):
    """What a result consists of: what it may have in common with others, and what is its own."""

    arrays: Arrays
    attributes: dict[str, Any]
    own_arrays: Arrays
    own_attributes: dict[str, Any]

    @property
    def whole(self) -> "Parts":
        """The same without a distinction."""
        return Parts(self.arrays | self.own_arrays, self.attributes | self.own_attributes, {}, {})

    def saying(self, **attributes: Any) -> "Parts":
        """Return the same with further attributes of its own."""
        return self._replace(own_attributes=self.own_attributes | attributes)

    @property
    def sharing(self) -> tuple[Any, ...]:
        """What results agree in that can lie in one group: the same arrays, and the form of their own."""
        common = [(name, id(array)) for name, (array, _) in self.arrays.items()]
        own = [(name, array.shape, array.dtype) for name, (array, _) in self.own_arrays.items()]
        return tuple(common), tuple(own), repr(self.attributes)


def split(result: Any) -> Parts:
    """Part the fields of a dataclass into arrays with their metadata and attributes; check dimensions."""
    parts = Parts({}, {}, {}, {})
    sizes: dict[str, int] = {}
    for field in dataclasses.fields(result):
        value = getattr(result, field.name)
        own = bool(field.metadata.get("own"))
        arrays, attributes = parts[2:] if own else parts[:2]
        if "dims" not in field.metadata:
            attributes[field.name] = _plain(value)
            continue
        if value is None:
            continue
        array = np.asarray(value)
        dims = field.metadata["dims"]
        if array.dtype.kind == "U":  # Zarr's format has no settled form for text
            attributes[field.name] = array.tolist()
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
        arrays[_called(field, lambda name: getattr(result, name))] = (array, field.metadata)
    return parts


def joined(kind: type[Result], found: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]) -> Result:
    """Return the dataclass that arrays and attributes were stored for."""
    values: dict[str, Any] = {}
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        if "dims" in field.metadata:
            name = _called(field, attributes.__getitem__)
            array = np.asarray(attributes[name]) if name in attributes else found.get(name)
            values[field.name] = array[()] if array is not None and array.ndim == 0 else array
        else:
            values[field.name] = _restored(attributes[field.name], field.type)
    return kind(**values)


def _called(field: "dataclasses.Field[Any]", attribute: Callable[[str], Any]) -> str:
    """Return an array's name in the store: its field's, or what another field of the result calls it."""
    return str(attribute(field.metadata["called_by"])) if "called_by" in field.metadata else field.name


def _plain(value: Any) -> Any:
    """Return an attribute as JSON can hold it: complex numbers as pairs, what is not finite as text."""
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


def _restored(value: Any, form: Any) -> Any:
    """Return an attribute as the dataclass holds it."""
    if form == tuple[float, ...]:
        return tuple(map(float, value))
    if isinstance(value, list):
        value = tuple(_restored(item, form) for item in value)
    if form in (complex, "complex"):
        return complex(*map(float, value)) if isinstance(value, tuple) else value
    return float(value) if form in (float, "float") else value
