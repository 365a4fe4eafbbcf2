"""What a study may ask for; what it may not is refused in one line that names the key."""

import math

import pytest

from railvib.errors import InputError
from sweep import study
from tests.sweep.study.tables import PAPER, changed


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("frequency.minimun_hz", 1.0, "frequency.minimun_hz: unknown key; did you mean minimum_hz?"),
        ("frequencies", {}, "frequencies: unknown key; did you mean frequency?"),
        ("frequency", 3, "frequency = 3: must be a table"),
        ("frequency.minimum_hz", 200, "frequency.minimum_hz = 200 Hz: must be below maximum_hz = 100 Hz"),
        ("frequency.minimum_hz", 100.0, "frequency.minimum_hz = 100 Hz: must be below maximum_hz = 100 Hz"),
        (
            "frequency.maximum_hz",
            900,
            "frequency.maximum_hz = 900 Hz: should be less than or equal to 500 Hz",
        ),
        ("frequency.maximum_hz", None, "frequency.maximum_hz: is missing"),
        ("study", None, "study: is missing"),
        ("study.name", "a/b", "study.name = 'a/b': may consist of letters, digits"),
        ("study.name", "Line 4 – Nord", "any text may be the title beside it"),
        ("study.name", "..", "study.name = '..': must not end with a dot"),
        ("study.name", "n" * 300, "has 300 bytes; must have at most 100"),
        ("study.title", "", "study.title = '': should have at least 1 character"),
        ("study.title", "two\nlines", r"study.title = 'two\nlines': must be one line"),
        ("study.title", "t" * 10**6, "should have at most 200 characters"),
        ("receivers.rail", "yes", "receivers.rail = 'yes': should be a valid boolean"),
        ("receivers.rail", 1, "receivers.rail = 1: should be a valid boolean"),
        (
            "receivers.offsets_m",
            [0, -8],
            "receivers.offsets_m[1] = -8 m: should be greater than or equal to 0 m",
        ),
        (
            "receivers.offsets_m",
            [1e5],
            "receivers.offsets_m[0] = 100000.0 m: should be less than or equal to 2000",
        ),
        ("receivers.offsets_m", ["8"], "receivers.offsets_m[0] = '8': should be a valid number"),
        ("receivers.offsets_m", [True], "receivers.offsets_m[0] = True: should be a valid number"),
        ("receivers.offsets_m", [8] * 1001, "must have at most 1000 values"),
        (
            "receivers",
            {"rail": False},
            "receivers.offsets_m = []: without the rail, at least one offset in m",
        ),
        (
            "approaches.compare",
            ["full", "fully"],
            "approaches.compare[1] = 'fully': should be 'moving-roughness'",
        ),
        ("approaches.compare", ["moving-roughness"], "approaches.reference = 'full': must be one of compare"),
        ("sweep.soil", ["s" * 250], "has 250 bytes; must have at most 100"),
        ("sweep.soil", ["greby"] * 1001, "must have at most 1000 values"),
        ("sweep.track", [], "sweep.track = []: must have at least one value"),
        ("sweep.track", ["CON"], "sweep.track[0] = 'CON': is the name of a device on Windows"),
        ("sweep.speed_kmh", [], "sweep.speed_kmh = []: must have at least one value"),
        (
            "sweep.speed_kmh",
            [150, 0],
            "sweep.speed_kmh[1] = 0 km/h: should be greater than or equal to 1 km/h",
        ),
        (
            "sweep.speed_kmh",
            [1e-3],
            "sweep.speed_kmh[0] = 0.001 km/h: should be greater than or equal to 1 km/h",
        ),
        (
            "sweep.speed_kmh",
            [3e8],
            "sweep.speed_kmh[0] = 300000000.0 km/h: should be less than or equal to 1000",
        ),
        ("sweep.speed_kmh", [math.nan], "sweep.speed_kmh[0] = nan km/h: should be a finite number"),
        ("sweep.speed_kmh", [math.inf], "sweep.speed_kmh[0] = inf km/h: should be a finite number"),
        ("sweep.speed_kmh", [10**400], "sweep.speed_kmh[0] = 1000"),
        ("sweep.speed_kmh", 150, "sweep.speed_kmh = 150 km/h: must be a list"),
        (
            "sweep.speed_kmh",
            {"start": 1, "stop": 2, "steps": 1},
            "sweep.speed_kmh: must be a list, {start, stop",
        ),
        (
            "sweep.speed_kmh",
            {"start": 9, "stop": 2, "step": 1},
            "sweep.speed_kmh.start = 9: must be below stop = 2",
        ),
        ("sweep.speed_kmh", [150] * 100_001, "must have at most 100000 values"),
        ("sweep.shear_speed_m_s", 200, "unknown key; it is a key of layers in [soil.<name>]"),
        ("sweep.offsets_m", [8], "sweep.offsets_m: unknown key; it is a key of [receivers]"),
        ("sweep.speed_m_s", [40], "give speed_kmh (3.6 v of a speed in m/s)"),
        ("tolerance", 1e-3, "tolerance: unknown key; it is a key of [accuracy]"),
        ("accuracy.tolerance", 0.5, "accuracy.tolerance = 0.5: should be less than or equal to 0.01"),
        ("output.narrow_band", "some", "output.narrow_band = 'some': should be 'all' or 'none'"),
        ("output.narrow_band", [{"approach": "full"}], "output.narrow_band[0].receiver: is missing"),
        ("soil", [1], "soil = [1]: must be a table"),
        ("soil.mine", [[[[[[[[[[[[[[[[[3]]]]]]]]]]]]]]]]], "is nested too deeply"),
        ("k" * 10**6, 1, "unknown key; known are accuracy, approaches"),
        ("accuracy.tolerance", "t" * 10**6, "should be a valid number"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_a_wrong_request_is_refused_in_one_line(path, value, message):
    with pytest.raises(InputError) as refusal:
        study.resolve(changed(path, value))
    assert message in str(refusal.value)
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 500


@pytest.mark.parametrize("path", sorted(PAPER.parent.glob("*.toml")), ids=lambda path: path.name)
def test_the_studies_that_come_with_it_are_valid(path):
    assert list(study.load(path).cases())
