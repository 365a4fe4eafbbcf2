"""What the decorators of compiled functions allow, whoever asks for a function first."""

import importlib
import pkgutil
import re

import numpy as np
from numba.core.dispatcher import Dispatcher

import railvib
from railvib.numerics.jit import fused_kernel, inline, kernel, reduction_kernel


@inline
def product_and_sum(x, y, z):
    return x * y + z


@kernel
def plainly(x):
    return product_and_sum(x, x, 1.0) * x - x


@reduction_kernel
def reordered(x):
    return product_and_sum(x, x, 1) * x - x


def flags(function, *arguments):
    """Return the flags of all multiplications, additions and subtractions in a compiled function's IR."""
    function(*arguments)
    function.recompile()  # what is loaded from the cache has no IR
    (code,) = function.inspect_llvm().values()
    found = re.findall(r"= f(?:mul|add|sub) ((?:[a-z]+ )*)(?:double|<)", code)
    assert found
    return {frozenset(each.split()) for each in found}


def test_an_inlined_function_is_compiled_alike_whoever_calls_it_first():
    for caller in (plainly, reordered):
        assert caller(3.0) == 27.0
        caller.recompile()  # what is loaded from the cache compiles nothing
    assert len(product_and_sum.overloads) == 2  # the callers' constants are of two types
    for each in product_and_sum.overloads.values():
        code = each.library.get_llvm_str()
        assert "reassoc" not in code
        assert code.count("contract") >= 2


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


def test_all_compiled_functions_state_all_settings():
    """Numba takes what is left out from the function that is being compiled, whichever that is."""
    count = 0
    for module in pkgutil.walk_packages(railvib.__path__, "railvib."):
        if module.name.endswith("__main__"):
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, Dispatcher):
                count += 1
                stated = value.targetoptions.keys()
                assert {"fastmath", "forceinline", "error_model"} <= stated, f"{module.name}.{name}"
    assert count > 50
