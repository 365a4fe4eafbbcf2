"""All code that is written in the compiler's intermediate language, LLVM IR.

It does what no compiler finds by itself: it keeps sums in vector registers over long loops, and reads a
floating-point number as an integer. Sizes are known when the code is compiled, so functions that depend on
them are made to measure. tests/railvib/numerics/test_intrinsics.py has a NumPy twin of each.
"""

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba import extending
from numba.core import types

_DOUBLE = ir.DoubleType()
_INT32, _INT64 = ir.IntType(32), ir.IntType(64)
_WIDTH = 8
"""Numbers in a vector; the compiler maps them to the registers that the processor has."""


def intrinsic(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of a typing context and types one that kernels can call, as Numba asks for."""
    compiled: Callable[..., Any] = extending.intrinsic(function)
    return compiled


@intrinsic
def bits(typingctx: Any, value: Any) -> Any:
    """Return the 64 bits of a double as an integer."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], _INT64)

    return types.int64(types.float64), codegen


@intrinsic
def double(typingctx: Any, value: Any) -> Any:
    """Return the double that has these 64 bits."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], _DOUBLE)

    return types.float64(types.int64), codegen


def row_subtraction(lanes: int) -> Callable[..., Any]:
    """Return the function that subtracts multiples of rows, each of `lanes` numbers side by side.

    It is called with (real, imag, target, source, factor) and subtracts `factor`, real and imaginary parts
    (2, lanes), times row `source` from row `target`, complex, lane by lane. `real` and `imag` are arrays
    whose numbers are counted in rows. A compiler that does not know that rows differ would load them again
    after every store.
    """

    @intrinsic
    def subtract_row(typingctx: Any, real: Any, imag: Any, target: Any, source: Any, factor: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            vector = ir.VectorType(_DOUBLE, lanes)

            def place(argument: int, row: Any) -> Any:
                data = _data(context, builder, signature, args, argument)
                return builder.gep(builder.bitcast(data, vector.as_pointer()), [row])

            def load(argument: int, row: Any) -> Any:
                return builder.load(place(argument, row), align=8)

            a, b = (load(4, ir.Constant(_INT64, part)) for part in (0, 1))
            minus_a, minus_b = builder.fneg(a), builder.fneg(b)
            x, y = load(0, args[3]), load(1, args[3])
            for argument, (of_x, of_y) in ((0, (minus_a, b)), (1, (minus_b, minus_a))):
                value = _multiply_add(builder, of_x, x, load(argument, args[2]))
                value = _multiply_add(builder, of_y, y, value)
                builder.store(value, place(argument, args[2]), align=8)
            return context.get_dummy_value()

        return types.none(real, imag, types.int64, types.int64, factor), codegen

    return subtract_row


def bilinear_sum(
    rows: int, columns: int, lanes: int, row_weight: int, column_weight: int
) -> Callable[..., Any]:
    """Return the function that sums complex numbers over some rows and columns, weighted by both.

    It is called with (value, start, width, weight, lane) and returns Σ_m a_m Σ_j b_j z_mj over `rows` rows m
    and `columns` columns j, where z_mj has its parts at value[start + m·width + 2j] and the place after. The
    weights a and b are in column `lane` of `weight` (…, lanes), from its rows `row_weight` and
    `column_weight` on. An even number of columns fills whole vectors.
    """
    parts = 2 * columns // _WIDTH
    vector, pairs = ir.VectorType(_DOUBLE, _WIDTH), ir.VectorType(_DOUBLE, _WIDTH // 2)

    @intrinsic
    def sum_bilinear(typingctx: Any, value: Any, start: Any, width: Any, weight: Any, lane: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            values = _data(context, builder, signature, args, 0)
            weights = _data(context, builder, signature, args, 3)

            def load_weight(row: int) -> Any:
                place = builder.add(ir.Constant(_INT64, row * lanes), args[4])
                return builder.load(builder.gep(weights, [place]))

            def shuffle(one: Any, order: list[int]) -> Any:
                return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(_INT32, len(order)), order))

            sums = [ir.Constant(vector, [0.0] * _WIDTH)] * parts
            row = builder.gep(values, [args[1]])
            for m in range(rows):
                a = _repeat(builder, load_weight(row_weight + m), vector)
                for part in range(parts):
                    place = builder.gep(row, [ir.Constant(_INT64, _WIDTH * part)])
                    z = builder.load(builder.bitcast(place, vector.as_pointer()), align=8)
                    sums[part] = _multiply_add(builder, a, z, sums[part])
                row = builder.gep(row, [args[2]])
            total = ir.Constant(vector, [0.0] * _WIDTH)
            for part in range(parts):
                b = ir.Constant(pairs, ir.Undefined)
                for k in range(_WIDTH // 2):
                    number = load_weight(column_weight + _WIDTH // 2 * part + k)
                    b = builder.insert_element(b, number, ir.Constant(_INT32, k))
                twice = shuffle(b, [k // 2 for k in range(_WIDTH)])
                total = _multiply_add(builder, twice, sums[part], total)
            size = _WIDTH
            while size > 2:
                size //= 2
                halves = (list(range(size)), list(range(size, 2 * size)))
                total = builder.fadd(*(shuffle(total, half) for half in halves))
            out = context.make_complex(builder, types.complex128)
            out.real = builder.extract_element(total, ir.Constant(_INT32, 0))
            out.imag = builder.extract_element(total, ir.Constant(_INT32, 1))
            return out._getvalue()

        return types.complex128(value, types.int64, types.int64, weight, types.int64), codegen

    return sum_bilinear


def square_moments(terms: int, node: Sequence[float], weight: Sequence[float]) -> Callable[..., Any]:
    """Return the function that adds moments of |A|² over an interval, A a complex polynomial.

    It is called with (series, start, plane, place, sums) and adds, at nodes t and weights w of a quadrature
    over −1 < t < 1, w·half·|A|²·yⁿ to sums (terms, nodes) for n from 0 to `terms` − 1. The real part of A is
    p − sign·s, the imaginary part q + sign·r; the coefficients of p, q, r, s in powers of x begin at `start`
    in `series` and are `plane` numbers apart. `place` is (x at t = 0, slope of x, y at t = 0, slope of y,
    half, sign).
    """
    nodes = len(node)
    vector = ir.VectorType(_DOUBLE, nodes)

    @intrinsic
    def add_square_moments(typingctx: Any, series: Any, start: Any, plane: Any, place: Any, sums: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            numbers = _data(context, builder, signature, args, 0)
            totals = _data(context, builder, signature, args, 4)
            x0, x1, y0, y1, half, sign = (
                _repeat(builder, builder.extract_value(args[3], k), vector) for k in range(6)
            )
            minus = builder.fneg(sign)
            starts = [args[1]]
            for _ in range(3):
                starts.append(builder.add(starts[-1], args[2]))
            p, q, r, s = (builder.gep(numbers, [each]) for each in starts)

            def coefficient(part: Any, n: int) -> Any:
                number = builder.load(builder.gep(part, [ir.Constant(_INT64, n)]))
                return _repeat(builder, number, vector)

            def amplitude(n: int) -> tuple[Any, Any]:
                real = _multiply_add(builder, minus, coefficient(s, n), coefficient(p, n))
                return real, _multiply_add(builder, sign, coefficient(r, n), coefficient(q, n))

            t = ir.Constant(vector, list(node))
            x = _multiply_add(builder, x1, t, x0)
            real, imag = amplitude(terms - 1)
            for n in range(terms - 2, -1, -1):
                next_real, next_imag = amplitude(n)
                real = _multiply_add(builder, real, x, next_real)
                imag = _multiply_add(builder, imag, x, next_imag)
            square = _multiply_add(builder, real, real, builder.fmul(imag, imag))
            moment = builder.fmul(square, builder.fmul(half, ir.Constant(vector, list(weight))))
            y = _multiply_add(builder, y1, t, y0)
            for n in range(terms):
                place = builder.gep(totals, [ir.Constant(_INT64, n * nodes)])
                place = builder.bitcast(place, vector.as_pointer())
                builder.store(builder.fadd(builder.load(place, align=8), moment), place, align=8)
                moment = builder.fmul(moment, y)
            return context.get_dummy_value()

        return types.none(series, types.int64, types.int64, place, sums), codegen

    return add_square_moments


def _data(context: Any, builder: Any, signature: Any, args: Any, argument: int) -> Any:
    """Return the pointer to the numbers of an argument that is an array."""
    return context.make_array(signature.args[argument])(context, builder, args[argument]).data


def _repeat(builder: Any, number: Any, vector: Any) -> Any:
    """Return a vector that holds one number everywhere."""
    empty = ir.Constant(vector, ir.Undefined)
    single = builder.insert_element(empty, number, ir.Constant(_INT32, 0))
    order = ir.Constant(ir.VectorType(_INT32, vector.count), [0] * vector.count)
    return builder.shuffle_vector(single, empty, order)


def _multiply_add(builder: Any, one: Any, other: Any, addend: Any) -> Any:
    """Return one·other + addend, which the compiler may fuse."""
    product = builder.fmul(one, other, flags=("contract",))
    return builder.fadd(product, addend, flags=("contract",))
