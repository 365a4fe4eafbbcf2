"""The common form of every physical input: frozen, validated once, SI inside, units in the names at the edge.

A field is called as the field's engineers call it (`density`), and its alias carries the unit
(`density_kg_m3`). Python code uses the name, study files use the alias; both build the same object.
"""

import re
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from railvib.errors import InputError

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
LossFactor = Annotated[float, Field(ge=0.0, le=1.0)]


class Parameters(BaseModel):
    """A frozen set of physical parameters; unknown names, NaN and infinity are refused.

    Raises
    ------
    InputError
        From the constructor, with one line per call naming the key, the value and what is allowed.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        validate_by_name=True,
        validate_by_alias=True,
        allow_inf_nan=False,
        str_strip_whitespace=True,
    )

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise InputError(describe(error, type(self).__name__)) from None


def describe(error: ValidationError, where: str) -> str:
    """Return the first fault of a validation in one line: key, value, what is allowed.

    Parameters
    ----------
    error
        The fault as pydantic reports it.
    where
        The path to put before the key, such as ``soil.greby``.
    """
    faults = error.errors(include_url=False)
    first = faults[0]
    key = where
    for part in first["loc"]:
        key += f"[{part}]" if isinstance(part, int) else f".{part}"
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    inner = first.get("ctx", {}).get("error")
    if isinstance(
        inner, InputError
    ):  # from a nested object, which names itself first: its place says more than its class
        return key + re.sub(r"^\w+(?=[.:\[])", "", str(inner)) + more
    allowed = first["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
    if first["type"] == "extra_forbidden":
        allowed = "unknown key"
    if first["type"] == "missing":
        return f"{key}: is missing{more}"
    if isinstance(first["input"], dict | list | tuple) or first["type"] == "extra_forbidden":
        return f"{key}: {allowed}{more}"
    return f"{key} = {first['input']!r}: {allowed}{more}"
