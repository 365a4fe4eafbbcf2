"""What the decorators of compiled functions allow."""

import re

import numpy as np

from railvib.numerics.jit import fused_kernel, kernel, reduction_kernel


def flags(function, *arguments):
    """Return the flags of all multiplications, additions and subtractions in a compiled function's IR."""
    function(*arguments)
    function.recompile()  # what is loaded from the cache has no IR
    (code,) = function.inspect_llvm().values()
    found = re.findall(r"= f(?:mul|add|sub) ((?:[a-z]+ )*)(?:double|<)", code)
    assert found
    return {frozenset(each.split()) for each in found}


@kernel
def plain_difference(x):
    return x * x - x


@fused_kernel
def fused_difference(x):
    return x * x - x


def test_arithmetic_of_kernels():
    assert flags(plain_difference, 3.0) == {frozenset()}
    assert flags(fused_difference, 3.0) == {frozenset({"nsz", "contract"})}


def test_reductions_may_be_reordered():
    assert flags(total, np.ones(5)) == {frozenset({"nsz", "contract", "reassoc"})}


@reduction_kernel
def total(x):
    out = 0.0
    for i in range(x.size):
        out += x[i]
    return out


def test_division_by_zero_is_infinite():
    assert inverse(0.0) == np.inf


@kernel
def inverse(x):
    return 1.0 / x
