"""Numbers that count the floating-point operations done with them.

A complex multiplication counts as four multiplications and two additions, one with a real number as two; a
subtraction counts as an addition; a fused multiply-add as two. Negation, comparison, choice between two
values, absolute value of a real number, and integer operations on exponents and signs are not counted. So the
count is a lower limit of the work, and the distance to it is never flattered.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.limit.rates import Rates


@dataclass
class Count:
    """Floating-point operations."""

    additions: float = 0
    multiplications: float = 0
    divisions: float = 0
    roots: float = 0

    @property
    def total(self) -> float:
        """Sum of all operations."""
        return self.additions + self.multiplications + self.divisions + self.roots

    def per(self, values: float) -> "Count":
        """Return the count per value."""
        return Count(*(number / values for number in vars(self).values()))

    def seconds(self, rates: Rates) -> float:
        """Return the shortest time possible if every operation takes half a multiply-add."""
        return self.total / rates.operations

    def seconds_by_kind(self, rates: Rates) -> float:
        """Return the shortest time possible with divisions and roots at their own rates."""
        fused = (self.additions + self.multiplications) / rates.operations
        return fused + self.divisions / rates.divisions + self.roots / rates.roots


@dataclass(frozen=True, eq=False)
class Real:
    """A real number that counts the operations done with it."""

    value: float
    count: Count = field(repr=False)

    def __add__(self, other: Any) -> Any:
        """Return the sum."""
        if is_complex(other):
            return _complex_of(self.count, self + other.real, other.imag)
        self.count.additions += 1
        return Real(self.value + value_of(other), self.count)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        """Return the difference."""
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        """Return the difference."""
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        """Return the product."""
        if is_complex(other):
            return _complex_of(self.count, self * other.real, self * other.imag)
        self.count.multiplications += 1
        return Real(self.value * value_of(other), self.count)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        """Return the quotient."""
        if is_complex(other):
            return self * _reciprocal(other)
        self.count.divisions += 1
        return Real(self.value / value_of(other), self.count)

    def __rtruediv__(self, other: Any) -> "Real":
        """Return the quotient."""
        self.count.divisions += 1
        return Real(value_of(other) / self.value, self.count)

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
        return self.value < value_of(other)

    def __le__(self, other: Any) -> bool:
        return self.value <= value_of(other)

    def __gt__(self, other: Any) -> bool:
        return self.value > value_of(other)

    def __ge__(self, other: Any) -> bool:
        return self.value >= value_of(other)

    def __float__(self) -> float:
        raise TypeError("a counting number would stop counting as a float")

    @property
    def real(self) -> "Real":
        """The number itself."""
        return self

    @property
    def imag(self) -> float:
        """Zero."""
        return 0.0


@dataclass(frozen=True, eq=False)
class Complex:
    """A complex number of two counting parts."""

    real: Real
    imag: Real

    def __add__(self, other: Any) -> "Complex":
        """Return the sum."""
        if not is_complex(other):
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
        if not is_complex(other):
            return Complex(self.real * other, self.imag * other)
        a, b, c, d = self.real, self.imag, other.real, other.imag
        return Complex(a * c - b * d, a * d + b * c)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        """Return the quotient, with one division."""
        return self * (_reciprocal(other) if is_complex(other) else 1.0 / other)

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


def is_complex(number: Any) -> bool:
    """Whether a number is complex, counting or not."""
    return isinstance(number, (Complex, complex))


def value_of(number: Any) -> float:
    """Return a real number as a float."""
    return number.value if isinstance(number, Real) else float(number)


def complex_number(real: Any = 0.0, imag: Any = 0.0) -> Any:
    """Stand in for the built-in `complex`; the result counts if a part does."""
    for part in (real, imag):
        if isinstance(part, Real):
            return _complex_of(part.count, real, imag)
    return real if isinstance(real, Complex) else complex(real, imag)


def to_counting(argument: Any, count: Count) -> Any:
    """Return an argument with every double in it replaced by a number that counts."""
    if isinstance(argument, np.ndarray):
        out = np.empty(argument.shape, object)
        out.ravel()[:] = [to_counting(number, count) for number in argument.ravel().tolist()]
        return out
    if isinstance(argument, complex):
        return Complex(Real(argument.real, count), Real(argument.imag, count))
    return Real(argument, count) if isinstance(argument, float) else argument


def to_plain(result: Any) -> Any:
    """Return a result with every counting number in it replaced by a plain one."""
    if isinstance(result, tuple):
        return tuple(to_plain(part) for part in result)
    if isinstance(result, np.ndarray):
        return np.array([to_plain(number) for number in result.ravel()]).reshape(result.shape)
    if isinstance(result, Complex):
        return complex(to_plain(result.real), to_plain(result.imag))
    return result.value if isinstance(result, Real) else result


def _reciprocal(number: Any) -> Any:
    """Return 1/z with one division."""
    scale = 1.0 / (number.real * number.real + number.imag * number.imag)
    return complex_number(number.real * scale, -number.imag * scale)


def _complex_of(count: Count, real: Any, imag: Any) -> Complex:
    parts = (part if isinstance(part, Real) else Real(float(part), count) for part in (real, imag))
    return Complex(*parts)
