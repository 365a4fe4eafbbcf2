"""The values of a numeric axis: a list, or a range that becomes one."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from railvib.errors import InputError
from railvib.parameters.validation import shown

LARGEST_AXIS = 100_000
SCALES = ("linear", "log")


def axis(value: Any) -> Any:
    """Return the values of a numeric axis: a list, {start, stop, step} or {start, stop, number, scale}.

    Raises
    ------
    InputError
        If a range is incomplete, does not ascend, or has more than `LARGEST_AXIS` values.
    """
    if not isinstance(value, Mapping):
        return value
    keys = set(value)
    if keys != {"start", "stop", "step"} and keys - {"scale"} != {"start", "stop", "number"}:
        raise InputError(
            ': must be a list, {start, stop, step} or {start, stop, number, scale = "log" | "linear"}'
        )
    numbers = {key: _number(key, value[key]) for key in keys - {"scale"}}
    start, stop = numbers["start"], numbers["stop"]
    scale = value.get("scale", "linear")
    if scale not in SCALES:
        raise InputError(f'.scale = {shown(scale)}: must be "log" or "linear"')
    if not start < stop:
        raise InputError(f".start = {start:g}: must be below stop = {stop:g}")
    if "step" in numbers:
        step = numbers["step"]
        if step <= 0.0:
            raise InputError(f".step = {step:g}: must be above 0")
        _check_length("step", step, (stop - start) / step + 1.0)
        intervals = math.floor((stop - start) / step * (1.0 + 1e-12))
        return _round(start + step * index for index in range(intervals + 1))
    number = numbers["number"]
    if number < 2 or number != int(number):
        raise InputError(f".number = {number:g}: must be an integer of 2 or more")
    _check_length("number", number, number)
    fractions = [index / (number - 1) for index in range(int(number))]
    if scale == "linear":
        return _round(start + (stop - start) * fraction for fraction in fractions)
    if start <= 0.0:
        raise InputError(f".start = {start:g}: must be above 0 for a logarithmic scale")
    return _round(start * (stop / start) ** fraction for fraction in fractions)


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f".{key} = {shown(value)}: must be a finite number")
    return float(value)


def _check_length(key: str, value: float, length: float) -> None:
    if not length < LARGEST_AXIS + 1.0:
        raise InputError(f".{key} = {value:g}: makes {length:.6g} values; must be at most {LARGEST_AXIS}")


def _round(values: Iterable[float]) -> list[float]:
    """Return values without rounding errors, so that they have the ids of the values typed in."""
    return [float(f"{value:.12g}") for value in values]
