"""Counting the floating-point operations of a compiled kernel, by running its source on numbers that count.

A kernel and the compiled functions that it calls are run as plain Python, with arrays of objects in place of
arrays of doubles. A complex multiplication counts as four multiplications and two additions, one with a real
number as two; a subtraction counts as an addition; a fused multiply-add as two. Negation, comparison, choice
between two values, absolute value of a real number, and the integer operations on exponents and signs are not
counted: so what is found is a lower limit of the work, and the distance to it is not made to look small.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import FunctionType
from typing import Any

import numpy as np

from benchmarks.arithmetic import Rates


@dataclass
class Count:
    """Floating-point operations."""

    additions: float = 0
    multiplications: float = 0
    divisions: float = 0
    roots: float = 0

    @property
    def total(self) -> float:
        """All operations, each as one."""
        return self.additions + self.multiplications + self.divisions + self.roots

    def per(self, values: float) -> "Count":
        """Return the count per value."""
        return Count(*(each / values for each in vars(self).values()))

    def seconds(self, rates: Rates) -> float:
        """Return the time that they take at least, every operation as quick as half a multiply-add."""
        return self.total / rates.operations

    def seconds_by_kind(self, rates: Rates) -> float:
        """Return the same with divisions and roots at their own rates."""
        fused = (self.additions + self.multiplications) / rates.operations
        return fused + self.divisions / rates.divisions + self.roots / rates.roots


@dataclass(frozen=True, eq=False)
class Real:
    """A real number that counts what is done with it."""

    value: float
    count: Count = field(repr=False)

    def __add__(self, other: Any) -> Any:
        """Return the sum."""
        if _is_complex(other):
            return _complex_of(self.count, self + other.real, other.imag)
        self.count.additions += 1
        return Real(self.value + _value(other), self.count)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        """Return the difference."""
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        """Return the difference."""
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        """Return the product."""
        if _is_complex(other):
            return _complex_of(self.count, self * other.real, self * other.imag)
        self.count.multiplications += 1
        return Real(self.value * _value(other), self.count)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        """Return the quotient."""
        if _is_complex(other):
            return self * _reciprocal(other)
        self.count.divisions += 1
        return Real(self.value / _value(other), self.count)

    def __rtruediv__(self, other: Any) -> "Real":
        """Return the quotient."""
        self.count.divisions += 1
        return Real(_value(other) / self.value, self.count)

    def __pow__(self, exponent: int) -> Any:
        """Return the square."""
        if exponent != 2:
            raise NotImplementedError(f"power {exponent}")
        return self * self

    def sqrt(self) -> "Real":
        """Return the square root; numpy calls this."""
        self.count.roots += 1
        return Real(float(np.sqrt(self.value)), self.count)

    def __neg__(self) -> "Real":
        return Real(-self.value, self.count)

    def __abs__(self) -> "Real":
        return Real(abs(self.value), self.count)

    def __lt__(self, other: Any) -> bool:
        return self.value < _value(other)

    def __le__(self, other: Any) -> bool:
        return self.value <= _value(other)

    def __gt__(self, other: Any) -> bool:
        return self.value > _value(other)

    def __ge__(self, other: Any) -> bool:
        return self.value >= _value(other)

    def __float__(self) -> float:
        raise TypeError("a number that counts would stop counting as a float")

    @property
    def real(self) -> "Real":
        """The number itself."""
        return self

    @property
    def imag(self) -> float:
        """Nothing."""
        return 0.0


@dataclass(frozen=True, eq=False)
class Complex:
    """A complex number of two parts that count."""

    real: Real
    imag: Real

    def __add__(self, other: Any) -> "Complex":
        """Return the sum."""
        if not _is_complex(other):
            return Complex(self.real + other, self.imag)
        return Complex(self.real + other.real, self.imag + other.imag)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        """Return the difference."""
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        """Return the difference."""
        return (-self) + other

    def __mul__(self, other: Any) -> "Complex":
        """Return the product."""
        if not _is_complex(other):
            return Complex(self.real * other, self.imag * other)
        a, b, c, d = self.real, self.imag, other.real, other.imag
        return Complex(a * c - b * d, a * d + b * c)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        """Return the quotient, with one division."""
        return self * (_reciprocal(other) if _is_complex(other) else 1.0 / other)

    def __rtruediv__(self, other: Any) -> Any:
        """Return the quotient, with one division."""
        return _reciprocal(self) * other

    def __pow__(self, exponent: int) -> Any:
        """Return the square."""
        if exponent != 2:
            raise NotImplementedError(f"power {exponent}")
        return self * self

    def __neg__(self) -> "Complex":
        return Complex(-self.real, -self.imag)

    def __abs__(self) -> Real:
        squared: Real = self.real * self.real + self.imag * self.imag
        return squared.sqrt()


def counted(
    kernel: Callable[..., Any], arguments: tuple[Any, ...], plain: tuple[int, ...] = (), **constants: Any
) -> tuple[Any, Count]:
    """Run a compiled kernel on numbers that count; return its result as numbers again, and the count.

    Parameters
    ----------
    kernel
        A function compiled by numba.
    arguments
        What it is called with: arrays and numbers of doubles and complex doubles, and others.
    plain
        Positions of arguments that stay as they are.
    **constants
        Constants of the kernel's module that are given other values, such as the length to which it fills up.
    """
    count = Count()
    given = [each if i in plain else _counting(each, count) for i, each in enumerate(arguments)]
    with np.errstate(all="ignore"):
        result = _interpreted(kernel, {}, constants)(*given)
    return _numbers(result), count


def _interpreted(
    kernel: Any, made: dict[Any, Callable[..., Any]], constants: dict[str, Any]
) -> Callable[..., Any]:
    """Return the source of a compiled function as plain Python that works on numbers that count."""
    if kernel in made:
        return made[kernel]
    source = kernel.py_func
    names = source.__globals__ | {name: constants[name] for name in constants if name in source.__globals__}
    function = FunctionType(source.__code__, names, source.__name__, source.__defaults__, source.__closure__)
    made[kernel] = function
    names.update(complex=_complex, np=_Arrays())
    for name in source.__code__.co_names:
        value = names.get(name)
        if hasattr(value, "py_func"):
            names[name] = _interpreted(value, made, constants)
        elif name in _BITS:
            names[name] = _BITS[name](made)
    return function


class _Arrays:
    """Numpy, whose new arrays hold objects."""

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)

    def empty(self, shape: Any, dtype: Any = None) -> np.ndarray:
        return np.empty(shape, object)

    def zeros(self, shape: Any, dtype: Any = None) -> np.ndarray:
        return np.full(shape, 0.0, object)

    def full(self, shape: Any, value: Any, dtype: Any = None) -> np.ndarray:
        return np.full(shape, value, object)


def _bits(made: Any) -> Callable[[Any], np.int64]:
    return lambda number: np.float64(_value(number)).view(np.int64)


def _double(made: Any) -> Callable[[np.int64], float]:
    """Return what gives a number of known bits; as a plain one, which meets one that counts next."""
    return lambda bits: float(np.int64(bits).view(np.float64))


_BITS = {"bits": _bits, "double": _double}
"""Stand-ins for the functions of `railvib.numerics.intrinsics` that have no Python source."""


def _is_complex(number: Any) -> bool:
    return isinstance(number, (Complex, complex))


def _reciprocal(number: Any) -> Any:
    """Return 1/z with one division."""
    scale = 1.0 / (number.real * number.real + number.imag * number.imag)
    return _complex(number.real * scale, -number.imag * scale)


def _value(number: Any) -> float:
    return number.value if isinstance(number, Real) else float(number)


def _complex(real: Any = 0.0, imag: Any = 0.0) -> Any:
    """Stand in for the built-in of that name."""
    for each in (real, imag):
        if isinstance(each, Real):
            return _complex_of(each.count, real, imag)
    return real if isinstance(real, Complex) else complex(real, imag)


def _complex_of(count: Count, real: Any, imag: Any) -> Complex:
    parts = (each if isinstance(each, Real) else Real(float(each), count) for each in (real, imag))
    return Complex(*parts)


def _counting(given: Any, count: Count) -> Any:
    """Return an argument with every double in it counting."""
    if isinstance(given, np.ndarray):
        out = np.empty(given.shape, object)
        out.ravel()[:] = [_counting(each, count) for each in given.ravel().tolist()]
        return out
    if isinstance(given, complex):
        return Complex(Real(given.real, count), Real(given.imag, count))
    return Real(given, count) if isinstance(given, float) else given


def _numbers(result: Any) -> Any:
    """Return plain numbers for numbers that count."""
    if isinstance(result, tuple):
        return tuple(_numbers(each) for each in result)
    if isinstance(result, np.ndarray):
        return np.array([_numbers(each) for each in result.ravel()]).reshape(result.shape)
    if isinstance(result, Complex):
        return complex(_numbers(result.real), _numbers(result.imag))
    return result.value if isinstance(result, Real) else result
