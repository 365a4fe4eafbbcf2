"""The textbook grid reaches the error that it is asked for."""

import numpy as np
import pytest

from benchmarks.peers import fourier_grid
from railvib.soil.rational_fit import fit_flexibility


@pytest.mark.parametrize(("soil", "frequency"), [("horstwalde", 20.0), ("greby", 5.0), ("greby", 100.0)])
def test_the_grid_reaches_the_error_by_transforms_and_by_sums(soil, frequency, track, request):
    ground = request.getfixturevalue(soil)
    fit = fit_flexibility(ground, frequency, 1e-10)
    grid = fourier_grid.coarsest(ground, track, frequency, fit)
    flexibility = fourier_grid.kernel(ground, 2.0 * np.pi * frequency)
    surface_wave = 2.0 * np.pi * frequency / ground.slowest_speed
    rows = np.append(np.linspace(0.0, grid.along_range, 9), [0.93 * surface_wave, 1.02 * surface_wave])
    exact = fourier_grid.closed_form(fit, track.half_width, rows)
    transforms = fourier_grid.by_transform(flexibility, track.half_width, rows, grid)
    sums = fourier_grid.by_sums(flexibility, track.half_width, rows, grid, fourier_grid.cosines(grid))
    np.testing.assert_allclose(transforms, sums, rtol=1e-9, atol=1e-12 * abs(exact).max())
    assert (np.abs(transforms - exact) / np.abs(exact[:, :1])).max() < 1.1 * fourier_grid.ERROR
