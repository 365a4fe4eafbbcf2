"""The FE/BE model as a whole: what it refuses, symmetry, energy, and its tables against direct evaluation."""

import numpy as np
import pytest

from railvib.errors import InputError
from railvib.fe_be.model import FeBeModel, fe_be_response
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.cross_section import CrossSection
from railvib.soil.fits import GroundFits

BETA = np.array([0.0, 0.2, 0.9, 4.0])
SECTION = CrossSection(elements=2, rows=1)


@pytest.mark.parametrize(
    ("frequency", "offsets", "message"),
    [(0.0, [], "frequency = 0.0 Hz"), (np.inf, [], "frequency = inf Hz"), (5.0, [-1.0], "offset = -1.0 m")],
)
def test_what_has_no_response_is_refused(horstwalde, track, frequency, offsets, message):
    with pytest.raises(InputError, match=message):
        fe_be_response(horstwalde, track, SECTION, frequency, BETA, offsets)


def test_the_response_is_even_in_the_wavenumber_and_takes_in_energy(horstwalde, track):
    response = fe_be_response(horstwalde, track, SECTION, 20.0, BETA, [8.0])
    mirrored = fe_be_response(horstwalde, track, SECTION, 20.0, -BETA, [8.0])
    np.testing.assert_array_equal(response.rail, mirrored.rail)
    np.testing.assert_array_equal(response.ground, mirrored.ground)
    assert response.ground.shape == (1, BETA.size)
    assert response.force.shape == (BETA.size, 3, SECTION.elements)
    assert np.all(response.rail.imag < 0.0)


@pytest.mark.parametrize("soil", ["horstwalde", "greby"])
def test_what_a_table_holds_is_the_direct_response(request, track, soil):
    ground, block = request.getfixturevalue(soil), 2
    k = int(blocks.indices(block, 0)[12])
    frequency = float(blocks.frequency(0, k))
    evaluate = FeBeModel(ground, track, SECTION, block)(GroundFits(ground, block, 1e-9), track, [8.0], 1e-3)
    table = evaluate(0, k, BETA)
    direct = fe_be_response(ground, track, SECTION, frequency, BETA, evaluate.offsets)
    judged = np.concatenate([direct.rail[None], direct.ground])
    # The bed is interpolated to 1e-6 of its entries, the fits start from neighbours: 1e-5 of each function.
    size = np.abs(judged).max(axis=1, keepdims=True)
    assert np.abs((table - judged) / size).max() < 1e-5
