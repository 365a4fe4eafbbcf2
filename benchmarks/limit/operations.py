"""Counting the floating-point operations of a compiled kernel by running its source on counting numbers.

A kernel and the compiled functions that it calls run as plain Python, with arrays of objects in place of
arrays of doubles.
"""

from collections.abc import Callable
from types import FunctionType
from typing import Any

import numpy as np

from benchmarks.limit.counting import Count, complex_number, to_counting, to_plain, value_of


def count_operations(
    kernel: Callable[..., Any], arguments: tuple[Any, ...], plain: tuple[int, ...] = (), **constants: Any
) -> tuple[Any, Count]:
    """Run a compiled kernel on counting numbers; return its result as plain numbers, and the count.

    Parameters
    ----------
    kernel
        A function compiled by numba.
    arguments
        Its arguments: arrays and numbers of doubles and complex doubles, and others.
    plain
        Positions of arguments that are passed on unchanged.
    **constants
        Other values for constants of the kernel's module, such as the length that it pads to.
    """
    count = Count()
    counted = [
        argument if i in plain else to_counting(argument, count) for i, argument in enumerate(arguments)
    ]
    with np.errstate(all="ignore"):
        result = _interpret(kernel, {}, constants)(*counted)
    return to_plain(result), count


def _interpret(
    kernel: Any, functions: dict[Any, Callable[..., Any]], constants: dict[str, Any]
) -> Callable[..., Any]:
    """Return the source of a compiled function as plain Python that works on counting numbers."""
    if kernel in functions:
        return functions[kernel]
    source = kernel.py_func
    names = source.__globals__ | {name: constants[name] for name in constants if name in source.__globals__}
    function = FunctionType(source.__code__, names, source.__name__, source.__defaults__, source.__closure__)
    functions[kernel] = function
    names.update(complex=complex_number, np=_Arrays())
    for name in source.__code__.co_names:
        value = names.get(name)
        if hasattr(value, "py_func"):
            names[name] = _interpret(value, functions, constants)
        elif name in _INTRINSICS:
            names[name] = _INTRINSICS[name]
    return function


class _Arrays:
    """NumPy with new arrays of objects."""

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)

    def empty(self, shape: Any, dtype: Any = None) -> np.ndarray:
        return np.empty(shape, object)

    def zeros(self, shape: Any, dtype: Any = None) -> np.ndarray:
        return np.full(shape, 0.0, object)

    def full(self, shape: Any, value: Any, dtype: Any = None) -> np.ndarray:
        return np.full(shape, value, object)


def _bits(number: Any) -> np.int64:
    """Return the bits of a number as an integer."""
    return np.float64(value_of(number)).view(np.int64)


def _double(bits: np.int64) -> float:
    """Return the number with these bits; it is plain, and counts as soon as it meets a number that counts."""
    return float(np.int64(bits).view(np.float64))


_INTRINSICS: dict[str, Callable[[Any], Any]] = {"bits": _bits, "double": _double}
"""Stand-ins, by name, for functions of `railvib.numerics.intrinsics` that have no Python source."""
