"""Values of a day against worked examples: DIN 4150-2:1999, E DIN 4150-2:2023 and E DIN 45672-3:2023."""

import numpy as np
import pytest

from railvib.errors import InputError
from railvib.levels import daily, references
from railvib.levels.daily import TRAIN_FACTOR
from tests.data.levels import golden

FIRST, SECOND = [0.92, 0.6, 0.9], [0.2, 0.24]
"""Maxima of the clock intervals of two classes of trains, DIN 4150-2:1999 example C.8."""


def printed(case):
    (row,) = [row for row in golden.rows("din") if row["case"] == case]
    return float(row["oracle"])


def test_classes_of_trains_1999():
    severity = [daily.kb_ftm(FIRST), daily.kb_ftm(SECOND)]
    assert severity[0] == pytest.approx(printed("4150-2 C.8 class 1 KB_FTm"), rel=1e-5)
    assert severity[1] == pytest.approx(printed("4150-2 C.8 class 2 KB_FTm"), rel=1e-5)
    value = daily.kb_ftr(severity, [288, 192], "day")
    assert value == pytest.approx(printed("4150-2 C.8 KB_FTr"), rel=1e-5)
    assert round(value, 3) == 0.325


def test_quiet_intervals_count_as_zero():
    """The whole record of C.8: twenty intervals, fifteen of them without a train."""
    record = [*FIRST, *SECOND, *[0.1] * 15]
    assert daily.kb_ftm(record) == pytest.approx(printed("4150-2 C.8 20 Takte KB_FTm"), rel=1e-5)


def test_seven_trains_an_hour():
    """Figure D.1 reads seven trains an hour at KB_FTm = 0.2 for A_r = 0.05."""
    seven = daily.kb_ftr(0.2, 7 * 16, "day")
    assert seven == pytest.approx(printed("4150-2 D.1 7 trains/h at 0.2"), rel=1e-5)
    assert seven < 0.05 < daily.kb_ftr(0.2, 8 * 16, "day")


def test_categories_of_trains_2023():
    """Example 8: the metro, below 0.1, counts as zero."""
    severity = [0.0365, 0.0468, 0.406, 0.568]
    trams = TRAIN_FACTOR["tram"]
    factor = [trams["underground"], trams["underground"], trams["surface"], trams["surface"]]
    value = daily.category_kb_ftr(severity, [144, 144, 80, 80], factor, "day")
    assert value == pytest.approx(0.0998, abs=5e-5)
    maximum = daily.MAXIMUM_FACTOR * np.array(severity)
    np.testing.assert_allclose(maximum, [0.055, 0.070, 0.609, 0.851], atol=1.1e-3)


def test_no_passage_of_a_category_is_suppressed():
    assert daily.category_kb_ftm([0.05, 0.5]) == pytest.approx(np.sqrt(0.5 * (0.05**2 + 0.5**2)))


def test_existing_and_planned_line_2023():
    """Example 9; the night over its 960 intervals, where the print has 920."""
    passenger, freight, long = (
        TRAIN_FACTOR[kind]["surface"] for kind in ("passenger", "freight", "long-freight")
    )
    existing = [0.24, 0.44], [passenger, freight]
    planned = [0.24, 0.22, 0.44, 0.40, 0.44, 0.40], [passenger] * 2 + [freight] * 2 + [long] * 2
    for (severity, factor), trains, period, expected in (
        (existing, [28, 8], "day", 0.039),
        (existing, [12, 18], "night", 0.065),
        (planned, [17, 17, 4, 4, 2, 2], "day", 0.046),
        (planned, [7, 7, 12, 12, 6, 6], "night", 0.094),
    ):
        assert round(daily.category_kb_ftr(severity, trains, factor, period), 3) == expected


def test_kb_from_bands():
    """E DIN 45672-3:2023 annex C by clause 7: 77.73 dB, KB_FTm 0.385, v_peak 1.73 mm/s."""
    rows = golden.rows("din_examples")
    band = 10.0 ** (np.round(10.0 * np.log10([float(row["band_hz"]) for row in rows])) / 10.0)
    level = [float(row["level_db"]) for row in rows]
    kb = daily.kb_of_bands(band, level)
    assert references.level((1e-3 * kb) ** 2, references.VELOCITY_DIN) == pytest.approx(77.73, abs=0.01)
    assert kb == pytest.approx(0.385, abs=5e-4)
    assert daily.PEAK_FACTOR * daily.MAXIMUM_FACTOR * kb == pytest.approx(1.73, abs=5e-3)
    trams = TRAIN_FACTOR["tram"]["surface"]
    assert daily.category_kb_ftr(0.40, 200, trams, "day") == pytest.approx(0.090, abs=5e-4)
    assert daily.category_kb_ftr(0.40, 20, trams, "night") == pytest.approx(0.040, abs=5e-4)


def test_v_per():
    value = daily.v_per([0.3, 0.09], [100, 1340], "day")
    assert value == pytest.approx(0.3 * np.sqrt(100 / 1440))
    assert daily.v_per(0.3, 40, "evening") == pytest.approx(0.3 * np.sqrt(40 / 480))


@pytest.mark.parametrize("number", [1, 2, 16])
def test_equal_events_add(number):
    """Energies by the number: two trains are 3.01 dB above one; doses by its fourth root."""
    energy = [daily.equivalent_mean_square(4e-9, 5.0, n, 3600.0) for n in (1, number)]
    assert 10.0 * np.log10(energy[1] / energy[0]) == pytest.approx(10.0 * np.log10(number))
    assert energy[0] == pytest.approx(4e-9 * 5.0 / 3600.0)
    assert daily.vdv_of_events(0.02, number) == pytest.approx(0.02 * number**0.25)
    ratio = daily.kb_ftr(0.3, number, "night") / daily.kb_ftr(0.3, 1, "night")
    assert 20.0 * np.log10(ratio) == pytest.approx(10.0 * np.log10(number))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: daily.kb_ftr(0.2, 10, "evening"), "period = 'evening': must be one of day, night"),
        (lambda: daily.kb_ftr([0.2, 0.3], [10], "day"), "2 values and 1 numbers"),
        (lambda: daily.kb_ftr(0.2, 961, "night"), "intervals = 961: a night has 960"),
        (lambda: daily.kb_ftm([]), "maxima = .*at least one"),
        (lambda: daily.vdv_of_events(-0.1, 3), "vdv = -0.1: must be finite and not negative"),
        (lambda: daily.v_per(0.1, np.nan, "day"), "numbers = nan: must be finite"),
    ],
)
def test_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
