"""The floating-point limit of one core: measured rates of multiply-add, division and square root.

The loops are written in LLVM IR, since no compiler turns Python or C into these instructions alone:
independent chains of vectors that stay in registers. Which vector length and how many chains are best depends
on the processor, so several are tried and the fastest counts.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils, types

from railvib.numerics.intrinsics import intrinsic

_LENGTHS = (2, 4, 8)
"""Doubles in a vector register: NEON and SSE, AVX2, AVX-512."""
_CHAINS = (8, 12, 16)
_RUN_S = 0.01


@dataclass(frozen=True)
class Rates:
    """Double-precision operations per second of one core in vector registers, the highest measured.

    Attributes
    ----------
    operations
        Multiplications and additions, in fused pairs that count as two.
    divisions, roots
        Each counts as one.
    """

    operations: float
    divisions: float
    roots: float


def measure() -> Rates:
    """Measure the rates of the core that this process runs on."""
    return Rates(2.0 * _highest("fma"), _highest("divide"), _highest("root"))


def _highest(operation: str) -> float:
    """Return operations per second of the fastest loop."""
    return max(
        length * chains * _passes_per_second(loop(operation, length, chains))
        for length in _LENGTHS
        for chains in (_CHAINS if operation == "fma" else _CHAINS[:1])
    )


def _passes_per_second(loop: Callable[[int], float]) -> float:
    """Return how often a loop's body runs per second, the best of several short runs."""
    loop(1)
    passes, duration = 1000, 0.0
    while duration < _RUN_S:
        passes *= 2
        duration = _seconds(loop, passes)
    return passes / min(duration, *(_seconds(loop, passes) for _ in range(4)))


def _seconds(loop: Callable[[int], float], passes: int) -> float:
    start = time.perf_counter()
    loop(passes)
    return time.perf_counter() - start


@cache
def loop(operation: str, length: int, chains: int) -> Callable[[int], float]:
    """Return a compiled loop of `chains` independent operations on vectors of `length` doubles."""
    vector = ir.VectorType(ir.DoubleType(), length)

    def constant(value: float) -> ir.Constant:
        return ir.Constant(vector, [ir.Constant(ir.DoubleType(), value)] * length)

    def step(builder: Any, x: Any) -> Any:
        if operation == "divide":
            return builder.fdiv(constant(1.7), x)
        name, arity = {"fma": ("fma", 3), "root": ("sqrt", 1)}[operation]
        function = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(vector, [vector] * arity), f"llvm.{name}.v{length}f64"
        )
        return builder.call(function, [x, constant(0.75), constant(0.5)][:arity])

    @intrinsic
    def body(typingctx: Any, count: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            chain = [cgutils.alloca_once_value(builder, constant(1.0 + 0.01 * i)) for i in range(chains)]
            with cgutils.for_range(builder, args[0]):
                for cell in chain:
                    builder.store(step(builder, builder.load(cell)), cell)
            total = builder.load(chain[0])
            for cell in chain[1:]:
                total = builder.fadd(total, builder.load(cell))
            out = ir.Constant(ir.DoubleType(), 0.0)
            for i in range(length):
                out = builder.fadd(out, builder.extract_element(total, ir.Constant(ir.IntType(32), i)))
            return out

        return types.float64(types.int64), codegen

    def run(count: int) -> float:
        return float(body(count))

    compiled: Callable[[int], float] = numba.njit()(run)
    return compiled
