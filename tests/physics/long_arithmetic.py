"""Complex numbers of many digits, on Python's decimals: enough to solve a linear system of exponentials."""

from __future__ import annotations

from decimal import Decimal, getcontext

Number = "Long | Decimal | int | float | complex"


class Long:
    """A complex number in the precision of the current decimal context."""

    __slots__ = ("imag", "real")

    def __init__(self, value: Number, imag: Decimal | None = None) -> None:
        if isinstance(value, Long):
            self.real, self.imag = value.real, value.imag
        elif isinstance(value, complex):
            self.real, self.imag = Decimal(value.real), Decimal(value.imag)
        else:
            self.real, self.imag = Decimal(value), imag or Decimal(0)

    def __add__(self, other: Number) -> Long:
        other = Long(other)
        return Long(self.real + other.real, self.imag + other.imag)

    def __neg__(self) -> Long:
        return Long(-self.real, -self.imag)

    def __sub__(self, other: Number) -> Long:
        return self + -Long(other)

    def __rsub__(self, other: Number) -> Long:
        return Long(other) - self

    def __mul__(self, other: Number) -> Long:
        other = Long(other)
        return Long(
            self.real * other.real - self.imag * other.imag, self.real * other.imag + self.imag * other.real
        )

    def __truediv__(self, other: Number) -> Long:
        other = Long(other)
        size = other.real**2 + other.imag**2
        return self * Long(other.real / size, -other.imag / size)

    __radd__, __rmul__ = __add__, __mul__

    def __abs__(self) -> Decimal:
        return (self.real**2 + self.imag**2).sqrt()

    def __complex__(self) -> complex:
        return complex(float(self.real), float(self.imag))

    def sqrt(self) -> Long:
        """Return the root with a real part that is not negative."""
        size = abs(self)
        if size == 0:
            return Long(0)
        big = ((size + abs(self.real)) / 2).sqrt()
        small = abs(self.imag) / (2 * big)
        real, imag = (big, small) if self.real >= 0 else (small, big)
        return Long(real, imag if self.imag >= 0 else -imag)

    def exp(self) -> Long:
        """Return e to this power: the series of a power 2^24 times smaller, squared 24 times."""
        if self.real < -20000:  # nothing is left of it, and the series would need more halvings
            return Long(0)
        x = self * (Decimal(1) / 2**24)
        term = total = Long(1)
        for n in range(1, getcontext().prec):
            term = term * x * (Decimal(1) / n)
            total = total + term
        for _ in range(24):
            total = total * total
        return total


def solve(matrix: list[list[Long]], right: list[Long]) -> list[Long]:
    """Return the solution of a linear system by elimination with row pivots."""
    rows = [[*row, b] for row, b in zip(matrix, right, strict=True)]
    n = len(rows)
    for i in range(n):
        best = max(range(i, n), key=lambda j: abs(rows[j][i]))
        rows[i], rows[best] = rows[best], rows[i]
        for j in range(i + 1, n):
            if abs(rows[j][i]) != 0:
                ratio = rows[j][i] / rows[i][i]
                rows[j] = [
                    a - ratio * b if c >= i else a
                    for c, (a, b) in enumerate(zip(rows[j], rows[i], strict=True))
                ]
    out: list[Long] = [Long(0)] * n
    for i in reversed(range(n)):
        out[i] = (rows[i][n] - sum((rows[i][j] * out[j] for j in range(i + 1, n)), Long(0))) / rows[i][i]
    return out
