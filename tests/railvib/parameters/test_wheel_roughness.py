"""Roughness of wheels: variances of orders and bands, where it ends, and what is refused."""

import numpy as np
import pytest

from railvib import library
from railvib.errors import InputError
from railvib.parameters.wheel_roughness import WheelRoughness

AROUND = 2.89


def test_orders_have_their_variance():
    """Each within half a decibel over its width of one order, where neighbours differ by up to 3 dB: between
    orders the density is a power law, so that it has no steps. The sum is within 0.2 dB.
    """
    levels = [22.0, 20.0, 21.0, 18.0, 16.0, 15.0, 13.0]
    spectrum = WheelRoughness(form="orders", order_level_db=levels).spectrum
    order = np.arange(1, 8)
    lower, upper = (2.0 * np.pi / AROUND * (order + side) for side in (-0.5, 0.5))
    variance = spectrum.band_mean_square(lower, upper)
    expected = 1e-12 * 10.0 ** (np.array(levels) / 10.0)
    np.testing.assert_allclose(10.0 * np.log10(variance / expected), 0.0, atol=0.5)
    assert abs(10.0 * np.log10(variance.sum() / expected.sum())) < 0.2


def test_one_order_alone():
    spectrum = WheelRoughness(form="orders", order_level_db=[40.0], circumference_m=3.0).spectrum
    variance = spectrum.band_mean_square(1e-3, 1e3)
    assert variance == pytest.approx(1e-12 * 10.0**4, rel=1e-12)
    assert spectrum.psd(2.0 * np.pi / 3.0 * np.array([0.49, 1.51])).tolist() == [0.0, 0.0]


def test_no_roughness_is_longer_than_the_circumference():
    rough = {"form": "power-law", "amplitude_m3": 1e-9, "exponent": 2.0}
    spectrum = WheelRoughness(**rough).spectrum
    assert spectrum.psd(2.0 * np.pi / (AROUND + 0.01)) == 0.0
    n = 2.0
    assert spectrum.psd(2.0 * np.pi * n) == pytest.approx(1e-9 / n**2 / (2.0 * np.pi))
    table = WheelRoughness(form="table", wavelength_m=[0.01, 0.1, 5.0], level_db=[-5.0, 5.0, 20.0]).spectrum
    assert table.cut_offs == (0.01, AROUND)
    assert table.extrapolated_share(0.1, 1e4) == 0.0


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"form": "orders"}, r"form = 'orders': needs order_level_db, here given: none"),
        ({"form": "orders", "order_level_db": []}, r"order_level_db = \[\]: must have at least one value"),
        (
            {"form": "orders", "order_level_db": [20.0], "exponent": 2},
            "here given: exponent, order_level_db",
        ),
        (
            {"form": "table", "wavelength_m": [0.1, 1.0]},
            "needs wavelength_m and level_db or wavelength_m and",
        ),
        (
            {"form": "table", "wavelength_m": [0.1], "level_db": [3.0]},
            "a table needs equally many, at least 2",
        ),
        (
            {"form": "table", "wavelength_m": [5.0, 9.0], "level_db": [3.0, 3.0]},
            "must be below maximum_wavelength",
        ),
        ({"form": "fra-av"}, "form = 'fra-av': should be 'table', 'power-law' or 'orders'"),
        (
            {"form": "orders", "order_level_db": [1.0], "circumference_m": 0.1},
            "circumference_m = 0.1 m: should be",
        ),
    ],
)
def test_refused(table, message):
    with pytest.raises(InputError, match=message):
        WheelRoughness(**table)


def test_wheels_of_a_train():
    rough = {"form": "orders", "order_level_db": [20.0]}
    vehicles = ["stem-locomotive", {"vehicle": "regina", "number": 2, "wheel_roughness": rough}]
    train = library.build("train", vehicles, where="train.x")
    spectra = train.wheel_spectra
    assert [each is not None for each in spectra] == [True] * 8 + [False] * 4
    assert train.has_rough_wheels
    assert not library.load("train", "grona-taget").has_rough_wheels
    smooth = library.load("vehicle", "regina")
    assert train.vehicles[1].model_copy(update={"wheel_roughness": None}) == smooth
    assert library.resolve_train(train.model_dump(by_alias=True, exclude_none=True)) == train
    with pytest.raises(InputError, match=r"^train\.x\[0\]\.wheel_roughness\.form = 'square': should be"):
        library.build(
            "train", [{"vehicle": "regina", "wheel_roughness": {"form": "square"}}], where="train.x"
        )
    with pytest.raises(InputError, match=r"^train\.x\[0\]\.wheel_roughness = 3: must be a table"):
        library.build("train", [{"vehicle": "regina", "wheel_roughness": 3}], where="train.x")
