"""What a cross-section may be."""

import pytest

from railvib.errors import InputError
from railvib.parameters.cross_section import CrossSection


def test_solid_stands_for_stiffness_and_mass(track):
    section = CrossSection(layer_height=0.5)
    (ballast,) = track.bed
    assert section.constrained_modulus(track, ballast) == pytest.approx(4640e6 * 0.5 / 3.2)
    assert section.density(track, ballast) == pytest.approx(1740.0 / (0.5 * 3.2))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"layer_height_m": 0.0}, "layer_height_m"),
        ({"poisson_ratio": 0.5}, "poisson_ratio = 0.5"),
        ({"bed": "columns"}, 'must be "smooth"'),
        ({"displacement": "centre"}, 'needs bed = "columns"'),
        ({"elements": 0}, "elements = 0"),
    ],
)
def test_what_cannot_be_is_refused(values, message):
    with pytest.raises(InputError, match=message):
        CrossSection(**values)
