"""Both ways by stiffness matrices give railvib's flexibility."""

import numpy as np
import pytest

from benchmarks.peers import stiffness_matrices
from benchmarks.runs import soils
from railvib.soil._kernels.layers import surface_flexibilities

WAYS = [stiffness_matrices.by_linear_algebra, stiffness_matrices.by_elimination]


@pytest.mark.parametrize("layers", [1, 3, 10])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("frequency", [2.0, 20.0, 80.0])
def test_flexibility(layers, way, frequency):
    ground = soils.ground(layers)
    r = np.geomspace(0.05, 3.0, 40)
    omega = 2.0 * np.pi * frequency
    expected = surface_flexibilities(r, omega, ground.stack(), False)
    np.testing.assert_allclose(way(ground, r, omega), expected, rtol=1e-7)


@pytest.mark.parametrize("way", WAYS)
def test_bedrock(way, greby):
    bottom = greby.layers[1].model_copy(update={"thickness": 6.0})
    ground = greby.model_copy(update={"layers": (greby.layers[0], bottom), "base": "rigid"})
    r = np.geomspace(0.05, 3.0, 40)
    expected = surface_flexibilities(r, 60.0, ground.stack(), True)
    np.testing.assert_allclose(way(ground, r, 60.0), expected, rtol=1e-7)
