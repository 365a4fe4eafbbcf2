"""One-third octaves: the series, its limits and its edges."""

import numpy as np
import pytest

from railvib.errors import InputError
from railvib.numerics import third_octaves


def test_series():
    midbands = third_octaves.midbands(1.0, 100.0)
    np.testing.assert_allclose(midbands, 10 ** (np.arange(21) / 10))
    labels = [third_octaves.nominal_label(f) for f in midbands]
    assert labels == "1 1.25 1.6 2 2.5 3.15 4 5 6.3 8 10 12.5 16 20 25 31.5 40 50 63 80 100".split()
    assert [third_octaves.nominal_label(10 ** (n / 10)) for n in (-5, 27, 30)] == ["0.315", "500", "1000"]


@pytest.mark.parametrize(
    ("limits", "count"), [((1.6, 31.5), 14), ((1.25, 1.25), 1), ((10**0.2, 10**1.5), 14)]
)
def test_limits_may_be_nominal_or_exact(limits, count):
    assert third_octaves.midbands(*limits).size == count


@pytest.mark.parametrize(
    "limits", [(0.0, 10.0), (10.0, 1.0), (1.0, float("inf")), (float("nan"), 1.0), (1.1, 1.15)]
)
def test_refused_limits(limits):
    with pytest.raises(InputError, match="bands from"):
        third_octaves.midbands(*limits)


def test_bands_share_their_edges():
    lower, upper = third_octaves.edges(third_octaves.midbands(0.1, 1000.0))
    np.testing.assert_allclose(upper[:-1], lower[1:], rtol=1e-14)
