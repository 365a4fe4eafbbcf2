"""Adaptive quadrature of all wavenumbers together agrees with the closed forms."""

import numpy as np
import pytest

from benchmarks.peers import adaptive_quadrature, fourier_grid
from benchmarks.sections import transfer
from railvib.soil.rational_fit import fit_flexibility


@pytest.mark.parametrize("frequency", [1.0, 30.0])
def test_closed_forms(greby, track, frequency):
    fit = fit_flexibility(greby, frequency, 1e-10)
    beta = transfer.wavenumbers(greby, track, frequency, 60)
    exact = fourier_grid.closed_form(fit, track.half_width, beta)
    integrals = adaptive_quadrature.compliances(
        greby, track.half_width, beta, fourier_grid.OFFSETS, frequency, 1e-8
    )
    assert (np.abs(integrals - exact) / np.abs(exact[:, :1])).max() < 1e-6
