"""Direct evaluation of transfer functions."""

import numpy as np
import pytest

from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.track import Track
from railvib.soil.fits import GroundFits
from railvib.soil.rational_fit import RationalFit
from railvib.soil.strip import mean_fit_reach
from railvib.transfer.evaluation import Evaluation


@pytest.mark.parametrize("coupling", ["centre", "mean"])
def test_quadrature_takes_over_where_the_fit_fails(track, monkeypatch, coupling):
    """A fit that misses its tolerance is not used: quadrature gives the same, and the record says so."""
    track = Track(**{**track.model_dump(), "coupling": coupling})

    def failing(self, level, k):
        return RationalFit(np.array([1j]), np.array([1.0 + 0j]), 0j, 1.0, np.array([0.0]))

    ground = Ground(
        layers=[Layer(shear_speed=200.0, dilatational_speed=400.0, density=1800.0, loss_factor=0.2)]
    )
    fits = GroundFits(ground, -3, 1e-10, mean_fit_reach(track.half_width))
    beta = np.linspace(0.0, 3.0, 9)
    evaluate = Evaluation(fits, track, [8.0], 1e-4)
    fitted = evaluate(0, int(blocks.indices(-3, 0)[0]), beta)
    assert not evaluate.failed
    monkeypatch.setattr(GroundFits, "at", failing)
    again = Evaluation(fits, track, [8.0], 1e-4)
    computed = again(0, int(blocks.indices(-3, 0)[0]), beta)
    np.testing.assert_allclose(computed, fitted, rtol=1e-6)
    assert len(again.failed) == 1
