"""The kernel of the ground's flexibility, compiled and as plain Python, and its public form."""

import numpy as np
import pytest

from railvib.parameters.ground import Ground
from railvib.soil._kernels.layers import psv_flexibility, surface_flexibilities, surface_flexibility
from railvib.soil.flexibility import ground_flexibility


@pytest.mark.parametrize("base", ["half-space", "rigid"])
@pytest.mark.parametrize("omega", [0.0, 0.7, 126.0])
def test_compiled_equals_plain(greby, base, omega):
    layers = greby.layers
    if base == "rigid":
        layers = (*layers[:-1], layers[-1].model_copy(update={"thickness": 6.0}))
    stack = Ground(layers=layers, base=base).stack()
    for r in (1e-3, 0.4, 3.0 + 0j, 1.0 - 0.2j, 900.0):
        compiled = psv_flexibility(r, omega, stack, base == "rigid")
        plain = psv_flexibility.py_func(r, omega, stack, base == "rigid")
        np.testing.assert_allclose(plain, compiled, rtol=1e-12, atol=1e-12 * abs(compiled[3]))


def test_many_at_once(greby):
    r = np.linspace(0.0, 5.0, 11)
    many = surface_flexibilities(r, 60.0, greby.stack(), False)
    one_by_one = [surface_flexibility(each, 60.0, greby.stack(), False) for each in r]
    # Not to the last bit: the compiler fuses multiplications and additions of lanes in other places.
    np.testing.assert_allclose(many, one_by_one, rtol=1e-14)
    np.testing.assert_allclose(many, surface_flexibilities.py_func(r, 60.0, greby.stack(), False), rtol=1e-13)


def test_shapes_broadcast(greby):
    q = ground_flexibility(greby, np.linspace(0.1, 1.0, 4)[:, None], [5.0, 20.0, -20.0])
    assert q.shape == (4, 3)
    assert q[2, 1] == ground_flexibility(greby, 0.7, 20.0)
    np.testing.assert_array_equal(q[:, 2], q[:, 1].conj())
    assert ground_flexibility(greby, 0.7, 20.0).shape == ()
