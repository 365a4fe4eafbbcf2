"""The common form of every input: frozen, validated once, SI inside, units in the names at the edge.

A field is called as the field's engineers call it (`density`), and its alias carries the unit
(`density_kg_m3`). Python code uses the name, study files use the alias; both build the same object. The range
of a field is what its quantity can be at all; within it, what is unusual is warned about.
"""

import re
import typing
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from railvib.errors import InputError, PlausibilityWarning
from railvib.parameters.hints import hint
from railvib.parameters.units import unit_of

LARGEST_INTEGER = 2**53
"""Beyond it not every integer is a float."""

MESSAGES = {
    "too_short": "must have at least one value",
    "tuple_type": "must be a list",
    "too_long": "must have at most {max_length} values",
    "missing": "is missing",
    "int_parsing_size": "should be between -2^53 and 2^53",
    "dict_type": "must be a table",
    "model_type": "must be a table",
}
"""Of those faults whose general wording speaks of Python."""


def _check_number(value: Any) -> Any:
    """Refuse what pydantic would convert to a number, and integers that no float holds."""
    if isinstance(value, bool | np.bool_ | str | bytes):
        raise PydanticCustomError("number_type", "should be a valid number")
    if isinstance(value, int) and abs(value) > LARGEST_INTEGER:
        raise PydanticCustomError("number_size", "should be between -2^53 and 2^53")
    return value


Number = Annotated[float, BeforeValidator(_check_number)]
Integer = Annotated[int, BeforeValidator(_check_number)]
LossFactor = Annotated[Number, Field(ge=0.0, le=1.0)]

Model = TypeVar("Model", bound="Parameters")

_SILENT: ContextVar[bool] = ContextVar("_SILENT", default=False)


class Parameters(BaseModel):
    """A frozen set of parameters; unknown names, NaN and infinity are refused.

    Raises
    ------
    InputError
        From the constructor, with one line that names the key, the value and what is allowed.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", validate_by_name=True, validate_by_alias=True, allow_inf_nan=False
    )

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise InputError(_describe(error, type(self), values)) from None

    def unusual(self) -> Iterator[str]:
        """Yield what is legal but unusual in this table alone; each text begins with the key."""
        yield from ()

    def cautions(self) -> Iterator[str]:
        """Yield what is legal but unusual in this table and those inside; each text begins with the key."""
        yield from self.unusual()
        for key, value in zip(keys(type(self)), dict(self).values(), strict=True):
            for index, item in enumerate(value if isinstance(value, tuple) else (value,)):
                if isinstance(item, Parameters):
                    place = f"{key}[{index}]" if isinstance(value, tuple) else key
                    yield from (f"{place}.{text}" for text in item.cautions())

    @classmethod
    def places(cls) -> dict[str, str]:
        """Return the path of the table by each key of the tables inside this one."""
        places: dict[str, str] = {}
        for key, field in zip(keys(cls), cls.model_fields.values(), strict=True):
            for part in _parts(field.annotation):
                if isinstance(part, type) and issubclass(part, Parameters):
                    places |= {inner: f"{key}.{path}" for inner, path in part.places().items()}
                    places |= dict.fromkeys(keys(part), key)
        return places


def keys(model: type[Parameters]) -> list[str]:
    """Return the keys of a table as files have them, in the order of the model's fields."""
    return [field.alias or name for name, field in model.model_fields.items()]


def validated(model: type[Model], table: Mapping[str, Any], where: str = "") -> Model:
    """Return the object that a table of a file describes.

    Parameters
    ----------
    model
        Its class.
    table
        Its parameters.
    where
        The path of the table in its file, such as ``soil.greby``; errors and warnings begin with it.

    Raises
    ------
    InputError
        With one line on the first fault.

    Warns
    -----
    PlausibilityWarning
        If a value is unusual.
    """
    with without_cautions():
        try:
            thing = model(**table)
        except InputError as error:
            raise InputError((where + str(error).removeprefix(model.__name__)).lstrip(".: ")) from None
    warn(thing.cautions(), where)
    return thing


def warn(texts: Iterable[str], where: str = "") -> None:
    """Warn about what is unusual, unless an object is built whose cautions another one gives.

    Parameters
    ----------
    texts
        What is unusual, each text beginning with a key.
    where
        The path of the table that has these keys.
    """
    for text in texts:
        if not _SILENT.get():
            warnings.warn(f"{where}.{text}".lstrip("."), PlausibilityWarning, stacklevel=3)


@contextmanager
def without_cautions() -> Iterator[None]:
    """Build objects without warnings."""
    token = _SILENT.set(True)
    try:
        yield
    finally:
        _SILENT.reset(token)


def _describe(error: ValidationError, model: type[Parameters], values: Mapping[str, Any]) -> str:
    """Return the first fault in one line: the name of the model and the key, the value, what is allowed."""
    fault = _first(error.errors(include_url=False))
    # A union reports every alternative; its branches are no part of the key.
    parts = [
        part for part in fault["loc"] if isinstance(part, int) or not part.startswith(("tuple[", "literal["))
    ]
    path = model.__name__ + "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts)
    if fault["type"] == "extra_forbidden":
        return f"{path}: unknown key; {hint(str(parts[-1]), values, keys(model), model.places())}"
    cause = fault.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        # From an object inside, which names itself first: its place says more than its class.
        inner = re.sub(r"^[A-Z]\w*(?=[.:\[])", "", str(cause))
        return path + inner if inner.startswith((".", ":", "[")) else f"{path}: {inner}"
    message = re.sub(r"^(Value error, |\w+ (?=should ))", "", fault["msg"])
    if fault["type"] in MESSAGES:
        message = MESSAGES[fault["type"]].format(**fault.get("ctx", {}))
    value = fault["input"]
    if isinstance(value, Mapping) or fault["type"] == "missing":
        return f"{path}: {message}"
    if not isinstance(value, int | float) or isinstance(value, bool):
        return f"{path} = {shown(value)}: {message}"
    field = model.model_fields[str(parts[0])] if parts[0] in model.model_fields else None
    unit = unit_of((field and field.alias) or str(parts[0]))
    quantity = f"{path} = {shown(value)} {unit}".rstrip()
    return f"{quantity}: {message} {unit}".rstrip() if message[-1].isdigit() else f"{quantity}: {message}"


def _parts(annotation: Any) -> Iterator[Any]:
    """Yield the types that an annotation is made of."""
    arguments = typing.get_args(annotation)
    if not arguments:
        yield annotation
    for argument in arguments:
        yield from _parts(argument)


def _first(faults: list[ErrorDetails]) -> ErrorDetails:
    """Return the fault to name: a misspelt key before what is missing for it, of a union the form meant."""
    return min(
        faults,
        key=lambda fault: (
            fault["type"] != "extra_forbidden",
            fault["type"] == "literal_error" and not isinstance(fault["input"], str),
        ),
    )


def shown(value: Any) -> str:
    """Return a value as messages show it."""
    try:
        return repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, lists inside themselves
        return f"{type(value).__name__} too large to show"
