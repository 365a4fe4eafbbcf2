"""The decorators of compiled functions: the one place that knows Numba's settings.

All divide as NumPy does: a division by zero gives infinity and needs no branch, so loops fill vector
registers. Kernels are kept in Numba's cache. They differ in what the compiler may do to their arithmetic:

================== ====================================================================================
`kernel`           nothing: the arithmetic is as written
`fused_kernel`     fuse a product and a sum into one instruction, and ignore the sign of zero
`reduction_kernel` also reorder sums, so that a sum over an array fills vector registers
`inline`           as `fused_kernel`, compiled into each kernel that calls it
================== ====================================================================================

None may assume that numbers are finite: infinity and NaN mean something to the callers. Every setting is
stated. What is left out Numba takes from the function whose compilation asked for this one first, so that
results would depend on the order of calls.
"""

from collections.abc import Callable
from typing import Any, Protocol

import numba

_njit: Any = numba.njit
_FUSED = {"contract", "nsz"}


class Compiled(Protocol):
    """A compiled function; the first call with arguments of new types compiles it."""

    py_func: Callable[..., Any]
    """The same as plain Python."""
    stats: Any
    """Numba's account of its cache."""

    def __call__(self, *arguments: Any) -> Any:
        """Return what the function returns."""


def _compiler(**settings: Any) -> Callable[[Callable[..., Any]], Compiled]:
    compiler: Callable[[Callable[..., Any]], Compiled] = _njit(error_model="numpy", **settings)
    return compiler


def kernel(function: Callable[..., Any]) -> Compiled:
    """Compile a function whose arithmetic stays as written."""
    return _compiler(cache=True, fastmath=False, forceinline=False)(function)


def fused_kernel(function: Callable[..., Any]) -> Compiled:
    """Compile a function that may fuse products and sums, and may ignore the sign of zero."""
    return _compiler(cache=True, fastmath=_FUSED, forceinline=False)(function)


def reduction_kernel(function: Callable[..., Any]) -> Compiled:
    """Compile a function that may also reorder its sums."""
    return _compiler(cache=True, fastmath=_FUSED | {"reassoc"}, forceinline=False)(function)


def inline(function: Callable[..., Any]) -> Compiled:
    """Compile a function into each kernel that calls it, so that loops around the call are vectorised.

    LLVM inlines it, which compiles faster than Numba's own inlining.
    """
    return _compiler(fastmath=_FUSED, forceinline=True)(function)
