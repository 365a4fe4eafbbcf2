import base64

import numpy as np

from queries.report.packing import NONE, hundredths, text


def test_levels_are_kept_to_half_a_hundredth():
    levels = np.linspace(-120.0, 160.0, 1001)
    assert np.max(np.abs(hundredths(levels) / 100.0 - levels)) <= 0.005 + 1e-12


def test_what_is_no_level_stands_apart_from_all_levels():
    masked = np.ma.masked_array([1.0, 2.0], [False, True])
    assert hundredths(masked).tolist() == [100, NONE]
    assert hundredths(np.array([np.nan, np.inf, -1e9, 1e9])).tolist() == [NONE, NONE, NONE + 1, -NONE - 1]


def test_arrays_come_back_from_their_text():
    array = np.arange(-5, 7, dtype="<i2").reshape(3, 4)[:, ::2]
    assert np.frombuffer(base64.b64decode(text(array)), "<i2").tolist() == array.ravel().tolist()
