import math
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from railvib import library
from railvib.errors import InputError
from sweep import study

PAPER = Path(__file__).parents[2] / "studies" / "paper.toml"
LAYER = {"shear_speed_m_s": 100, "dilatational_speed_m_s": 200, "density_kg_m3": 1800, "loss_factor": 0.1}


def tables():
    return tomllib.loads(PAPER.read_text(encoding="utf-8"))


def changed(path, value):
    """Return the paper's study with one key set, or removed where the value is None."""
    data = tables()
    *parents, last = path.split(".")
    table = data
    for name in parents:
        table = table.setdefault(name, {})
    if value is None:
        del table[last]
    else:
        table[last] = value
    return data


def ids(data):
    return {case.case_id for case in study.resolve(data).cases()}


def test_the_papers_study():
    resolved = study.load(PAPER)
    cases = list(resolved.cases())
    assert [case.soil for case in cases] == ["horstwalde", "greby"]
    assert {case.speed_kmh for case in cases} == {150.0}
    assert resolved.objects["soil"]["greby"] == library.load("soil", "greby")
    assert resolved.study.accuracy.tolerance == 1e-4


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("frequency.minimun_hz", 1.0, "frequency.minimun_hz: unknown key; did you mean minimum_hz?"),
        ("frequencies", {}, "frequencies: unknown key; did you mean frequency?"),
        ("frequency.minimum_hz", 200, "frequency.minimum_hz = 200 Hz: must be below maximum_hz = 100 Hz"),
        ("frequency.minimum_hz", 100.0, "frequency.minimum_hz = 100 Hz: must be below maximum_hz = 100 Hz"),
        ("frequency.maximum_hz", 900, "frequency.maximum_hz = 900 Hz: should be less than or equal to 500"),
        ("frequency.maximum_hz", None, "frequency.maximum_hz: is missing"),
        ("study", None, "study: is missing"),
        ("study.name", "a/b", "study.name = 'a/b': may consist of letters, digits"),
        (
            "receivers.offsets_m",
            [0, -8],
            "receivers.offsets_m[1] = -8 m: should be greater than or equal to 0",
        ),
        ("receivers.offsets_m", ["8"], "receivers.offsets_m[0] = '8': should be a valid number"),
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
        ("sweep.soil", ["grebi"], "sweep.soil = 'grebi': is unknown; the nearest known is 'greby'"),
        ("sweep.track", [], "sweep.track = []: must have at least one value"),
        ("sweep.speed_kmh", [], "sweep.speed_kmh = []: must have at least one value"),
        ("sweep.speed_kmh", [150, 0], "sweep.speed_kmh[1] = 0 km/h: should be greater than 0"),
        ("sweep.speed_kmh", [math.nan], "sweep.speed_kmh[0] = nan km/h: should be a finite number"),
        ("sweep.speed_kmh", [math.inf], "sweep.speed_kmh[0] = inf km/h: should be a finite number"),
        ("sweep.speed_kmh", 150, "sweep.speed_kmh = 150 km/h: must be a list"),
        ("sweep.speed_kmh", {"start": 1, "stop": 2, "steps": 1}, "must be a list, {start, stop, step} or"),
        ("sweep.speed_kmh", {"start": 9, "stop": 2, "step": 1}, "start = 9 must be below stop = 2"),
        ("sweep.speed_kmh", {"start": 1, "stop": 2, "step": 0}, "step = 0 must be above 0"),
        ("sweep.speed_kmh", {"start": 1, "stop": 2, "step": 1e-9}, "values are more than 100000"),
        (
            "sweep.speed_kmh",
            {"start": 1, "stop": 2, "number": 1.5},
            "number = 1.5 must be an integer of 2 or more",
        ),
        (
            "sweep.speed_kmh",
            {"start": 0, "stop": 2, "number": 3, "scale": "log"},
            "start = 0 must be above 0",
        ),
        ("sweep.speed_kmh", {"start": 1, "stop": 2, "number": 3, "scale": "ln"}, "scale = 'ln' must be"),
        ("sweep.speed_kmh", {"start": math.nan, "stop": 2, "step": 1}, "start = nan must be a finite number"),
        ("accuracy.tolerance", 0.5, "accuracy.tolerance = 0.5: should be less than or equal to 0.01"),
        ("output.narrow_band", "some", "output.narrow_band = 'some': should be 'all' or 'none'"),
        ("output.narrow_band", [{"approach": "full"}], "output.narrow_band[0].receiver: is missing"),
        ("soil.mine", 3, "soil.mine = 3: must be a table of parameters"),
        ("soil.mine.layers", [], "soil.mine.layers"),
        (
            "soil.mine.layers",
            [LAYER | {"thickness_m": 3}],
            "soil.mine: layers[0].thickness_m = 3 m: the last layer",
        ),
        ("soil.mine.layers", [LAYER, LAYER], "layers[0].thickness_m is missing"),
        (
            "soil.mine.layers",
            [LAYER | {"los_factor": 1}],
            "soil.mine.layers[0].los_factor: unknown key; did you mean",
        ),
        (
            "soil.mine.layers",
            [LAYER | {"density_kg_m3": -1}],
            "soil.mine.layers[0].density_kg_m3 = -1: should be",
        ),
        (
            "soil.mine.layers",
            [LAYER | {"loss_factor": -0.1}],
            "soil.mine.layers[0].loss_factor = -0.1: should be",
        ),
        ("soil.mine.layers", [{"density_kg_m3": 1800}], "soil.mine.layers[0].shear_speed_m_s: is missing"),
        (
            "soil.mine.layers",
            [LAYER | {"dilatational_speed_m_s": 110}],
            "must exceed sqrt(4/3) of shear_speed_m_s = 100 m/s",
        ),
        ("train.mine.vehicles", ["regin"], "vehicle = 'regin': is unknown; the nearest known is 'regina'"),
    ],
)
def test_a_wrong_request_is_refused_in_one_line(path, value, message):
    with pytest.raises(InputError) as refusal:
        study.resolve(changed(path, value))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_half_written_file_is_refused_with_its_line(tmp_path):
    path = tmp_path / "half.toml"
    path.write_text('[study]\nname = "half\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"half\.toml: is not valid TOML: .*line 2"):
        study.load(path)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: cannot be read"):
        study.load(tmp_path / "none.toml")


def test_inline_definitions_stand_before_the_library():
    data = changed("soil.greby", {"layers": [LAYER]})
    assert study.resolve(data).objects["soil"]["greby"].layers[0].shear_speed == 100.0


def test_an_inline_copy_of_the_library_is_the_same_case():
    entry = library.entry("soil", "greby").parameters
    data = changed("soil", {"mine": dict(entry)})
    data["sweep"]["soil"] = ["mine", "horstwalde"]
    assert ids(data) == ids(tables())


@pytest.mark.parametrize("kind", ["soil", "track", "train", "unevenness"])
def test_two_names_for_equal_things_are_labels_of_one_case(kind):
    data = tables()
    (name, *_) = data["sweep"][kind]
    entry = dict(library.entry(kind, name).parameters)
    data["sweep"][kind] = [name, "mine"]
    data[kind] = {"mine": entry}
    one = changed(f"sweep.{kind}", [name])
    cases = list(study.resolve(data).cases())
    assert {case.case_id for case in cases} == ids(one)
    assert len(cases) == len(ids(one))
    for case in cases:
        assert [getattr(label, kind) for label in case.labels] == [name, "mine"]
        assert case.labels[0] == (case.soil, case.track, case.train, case.unevenness, case.speed_kmh)


def test_a_study_spelt_out_is_the_same_study():
    resolved = study.resolve(tables())
    again = study.resolve(resolved.document())
    assert [case.case_id for case in again.cases()] == [case.case_id for case in resolved.cases()]
    assert again.document() == resolved.document()


@pytest.mark.parametrize(
    ("given_as", "values"),
    [
        ({"start": 50, "stop": 60, "step": 5}, (50.0, 55.0, 60.0)),
        ({"start": 0.1, "stop": 0.5, "step": 0.1}, (0.1, 0.2, 0.3, 0.4, 0.5)),
        ({"start": 10, "stop": 25, "step": 10}, (10.0, 20.0)),
        ({"start": 10, "stop": 1000, "number": 3, "scale": "log"}, (10.0, 100.0, 1000.0)),
        ({"start": 10, "stop": 20, "number": 3}, (10.0, 15.0, 20.0)),
        ([150], (150.0,)),
    ],
)
def test_axes(given_as, values):
    assert study.resolve(changed("sweep.speed_kmh", given_as)).study.sweep.speed_kmh == values


speeds = st.lists(st.floats(1.0, 400.0), min_size=1, max_size=4, unique=True)


@given(speeds, st.randoms())
def test_order_and_names_change_no_id(values, random):
    shuffled = random.sample(values, len(values))
    one, other = changed("sweep.speed_kmh", values), changed("sweep.speed_kmh", shuffled)
    other["study"]["name"] = "another"
    other["sweep"]["soil"].reverse()
    assert ids(one) == ids(other)


@given(speeds)
def test_one_more_speed_leaves_the_other_cases(values):
    first, *rest = values
    more = ids(changed("sweep.speed_kmh", values))
    assert ids(changed("sweep.speed_kmh", [first])) <= more
    assert len(more) == 2 * (1 + len(rest))


def test_a_value_twice_is_one_case_with_one_label():
    cases = list(study.resolve(changed("sweep.speed_kmh", [150, 150.0])).cases())
    assert [len(case.labels) for case in cases] == [1, 1]
