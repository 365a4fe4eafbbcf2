"""What a ground is, and what it refuses."""

import math

import numpy as np
import pytest

from railvib.errors import InputError
from railvib.parameters.ground import Ground, Layer

SAND = {"shear_speed": 150.0, "dilatational_speed": 400.0, "density": 1800.0, "loss_factor": 0.05}


def test_names_and_aliases_make_the_same_layer():
    aliases = {
        "shear_speed_m_s": 150.0,
        "dilatational_speed_m_s": 400.0,
        "density_kg_m3": 1800.0,
        "loss_factor": 0.05,
    }
    assert Layer(**SAND) == Layer(**aliases)
    assert Layer(**SAND, thickness=2.0).model_dump(by_alias=True)["thickness_m"] == 2.0


def test_moduli():
    layer = Layer(**SAND)
    assert layer.shear_modulus == pytest.approx(1800.0 * 150.0**2)
    lame = 1800.0 * 400.0**2 - 2.0 * layer.shear_modulus
    assert layer.poisson_ratio == pytest.approx(lame / (2.0 * (lame + layer.shear_modulus)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"density": -1.0}, r"density = -1"),
        ({"density": math.nan}, "density = nan"),
        ({"shear_speed": 0.0}, "shear_speed = 0"),
        ({"dilatational_speed": 170.0}, "bulk modulus"),
        ({"loss_factor": -0.1}, "loss_factor = -0.1"),
        ({"loss_factor": 1.5}, "loss_factor = 1.5"),
        ({"thickness": 0.0}, "thickness = 0"),
        ({"colour": "brown"}, "colour"),
    ],
)
def test_refused_layers(change, message):
    with pytest.raises(InputError, match=message):
        Layer(**{**SAND, **change})


def test_bulk_modulus_may_be_almost_nothing():
    limit = math.sqrt(4.0 / 3.0) * 150.0
    Layer(**{**SAND, "dilatational_speed": limit * (1.0 + 1e-9)})
    with pytest.raises(InputError, match=f"{limit:.6g} m/s"):
        Layer(**{**SAND, "dilatational_speed": limit})


def test_refused_grounds():
    half_space, layer = Layer(**SAND), Layer(**SAND, thickness=2.0)
    with pytest.raises(InputError, match=r"layers\[0\]\.thickness_m: is missing"):
        Ground(layers=[half_space, half_space])
    with pytest.raises(InputError, match=r"layers\[1\]\.thickness_m = 2 m"):
        Ground(layers=[layer, layer])
    with pytest.raises(InputError, match=r"layers\[1\]\.thickness_m: is missing"):
        Ground(layers=[layer, half_space], base="rigid")
    with pytest.raises(InputError, match="layers"):
        Ground(layers=[])
    with pytest.raises(InputError, match="base"):
        Ground(layers=[layer], base="soft")


def test_stack():
    ground = Ground(layers=[Layer(**SAND, thickness=2.0), Layer(**SAND)])
    np.testing.assert_array_equal(
        ground.stack(), [[150.0, 400.0, 1800.0, 0.05, 2.0], [150.0, 400.0, 1800.0, 0.05, np.inf]]
    )
    assert ground.homogeneous
    assert not Ground(layers=[Layer(**SAND, thickness=2.0)], base="rigid").homogeneous
    assert not Ground(layers=[Layer(**SAND, thickness=2.0), Layer(**{**SAND, "density": 1900.0})]).homogeneous
