"""What holds for any valid study: its canonical form is the same study; physics enters ids, names do not.

Studies are made from the library's soils, tracks, vehicles and unevennesses with every number moved by up to
a percent, under names and in orders of their own.
"""

import copy
import json
import math
import string
import warnings
from collections.abc import Mapping

from hypothesis import given, settings
from hypothesis import strategies as st

from railvib import library
from railvib.errors import PlausibilityWarning
from railvib.numerics.third_octaves import midbands
from railvib.parameters.approach import APPROACHES
from sweep import study
from sweep.request import prepare
from sweep.study.names import check_name
from sweep.wanted import spectra_unit

SHELVES = {
    "soil": ("horstwalde", "greby"),
    "track": ("ballasted-paper", "slab-example", "ballasted-mean"),
    "unevenness": ("fra-hamid-yang-3", "fra-av-5", "german-low", "sncf-poor"),
    "vehicle": ("regina", "velaro-e", "velaro-e-trailer", "freight-y25-empty", "two-axle-wagon"),
}


def is_name(text):
    """Return whether a text can be a name."""
    try:
        return bool(check_name(text))
    except ValueError:
        return False


names = st.text(string.ascii_letters + string.digits + "_.+-", min_size=1, max_size=12).filter(is_name)
places = st.lists(names, min_size=1, max_size=2, unique=True)
speeds = st.lists(st.floats(10.0, 300.0), min_size=1, max_size=3, unique=True)
percent = st.floats(0.99, 1.01)


def moved(draw, value):
    """Return parameters with every number moved a little."""
    if isinstance(value, Mapping):
        return {key: moved(draw, item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [moved(draw, item) for item in value]
    return value * draw(percent) if isinstance(value, float) else value


def definitions(draw, kind):
    """Return one or two definitions of a kind under names of their own."""
    return {
        name: moved(draw, dict(library.entry(kind, draw(st.sampled_from(SHELVES[kind]))).parameters))
        for name in draw(places)
    }


@st.composite
def studies(draw):
    """Draw the tables of a valid study."""
    vehicles = definitions(draw, "vehicle")
    inline = {kind: definitions(draw, kind) for kind in ("soil", "track", "unevenness")}
    trains = {
        name: {
            "vehicles": [
                {"vehicle": vehicle, "number": draw(st.integers(1, 3))}
                for vehicle in draw(st.lists(st.sampled_from(sorted(vehicles)), min_size=1, max_size=2))
            ]
        }
        for name in draw(places)
    }
    low, high = sorted(draw(st.lists(st.integers(0, 26), min_size=2, max_size=2, unique=True)))
    band = midbands(0.1, 500.0)[[low, high]]
    compare = draw(st.lists(st.sampled_from(APPROACHES), min_size=1, unique=True))
    return {
        "study": {"name": draw(names)},
        "frequency": {"minimum_hz": float(band[0]), "maximum_hz": float(band[1])},
        "receivers": {
            "rail": True,
            "offsets_m": draw(st.lists(st.floats(0.0, 200.0), max_size=3, unique=True)),
        },
        "approaches": {"compare": compare, "reference": draw(st.sampled_from(compare))},
        "sweep": {
            **{kind: list(inline[kind]) for kind in ("soil", "track", "unevenness")},
            "train": list(trains),
            "speed_kmh": draw(speeds),
        },
        "accuracy": {"tolerance": draw(st.floats(1e-6, 1e-2))},
        **inline,
        "train": trains,
        "vehicle": vehicles,
    }


def ids(data):
    """Return the ids of a study's cases, and those of the units that hold their results."""
    resolved = study.resolve(data)
    cases = list(resolved.cases())
    wanted = {
        spectra_unit(resolved, case, approach).id
        for case in cases
        for approach in resolved.study.approaches.compare
    }
    return {case.case_id for case in cases}, wanted


@settings(max_examples=40)
@given(studies())
def test_a_study_is_its_canonical_form(data):
    resolved = study.resolve(data)
    document = json.loads(json.dumps(resolved.document()))
    assert ids(document) == ids(data)
    again = study.resolve(document)
    assert json.loads(json.dumps(again.document())) == document
    assert [case.case_id for case in again.cases()] == [case.case_id for case in resolved.cases()]


def leaves(value, place=()):
    """Yield the places of all numbers in some tables."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(item, (*place, key))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield place


def changed(data, place):
    """Return a study with one number changed: a speed in km/h is not told apart in its last digit."""
    other = copy.deepcopy(data)
    table = other
    for key in place[:-1]:
        table = table[key]
    value = table[place[-1]]
    if place[-1] == "line_class":
        table[place[-1]] = value % 6 + 1
    elif isinstance(value, int):
        table[place[-1]] = value + 1
    else:
        table[place[-1]] = value * (1.0 - 1e-12)
    return other


@settings(max_examples=150)
@given(studies(), st.data())
def test_any_change_of_a_physical_input_changes_the_ids(data, draw):
    for kind in ("vehicle", "train", "soil", "track", "unevenness"):
        if kind != "vehicle":  # one of each, so that every number of a definition counts
            kept = data["sweep"][kind][0]
            data["sweep"][kind] = [kept]
            data[kind] = {kept: data[kind][kept]}
    used = {group["vehicle"] for train in data["train"].values() for group in train["vehicles"]}
    data["vehicle"] = {name: table for name, table in data["vehicle"].items() if name in used}
    data["sweep"]["speed_kmh"] = data["sweep"]["speed_kmh"][:1]
    physical = {kind: data[kind] for kind in ("vehicle", "train", "soil", "track", "unevenness")}
    place = draw.draw(st.sampled_from([*leaves(physical), ("sweep", "speed_kmh", 0)]))
    cases, wanted = ids(data)
    with warnings.catch_warnings():  # the slowest usual speed less its last digit is cautioned about
        warnings.simplefilter("ignore", PlausibilityWarning)
        other_cases, other_wanted = ids(changed(data, place))
    assert cases.isdisjoint(other_cases), place
    assert wanted.isdisjoint(other_wanted), place


@settings(max_examples=40)
@given(studies(), st.data())
def test_what_is_asked_of_a_case_changes_the_ids_of_results_alone(data, draw):
    other = copy.deepcopy(data)
    match draw.draw(st.sampled_from(["tolerance", "minimum", "offset", "rail"])):
        case "tolerance":
            data["accuracy"]["tolerance"], other["accuracy"]["tolerance"] = 2e-4, math.nextafter(2e-4, 1.0)
        case "minimum":
            data["frequency"] |= {"minimum_hz": 1.0, "maximum_hz": 80.0}
            other["frequency"] = {"minimum_hz": 1.25, "maximum_hz": 80.0}
        case "offset":
            other["receivers"]["offsets_m"] = [*data["receivers"]["offsets_m"], 201.0]
        case "rail":
            data["receivers"] = {"rail": True, "offsets_m": [8.0]}
            other["receivers"] = {"rail": False, "offsets_m": [8.0]}
    cases, wanted = ids(data)
    other_cases, other_wanted = ids(other)
    assert cases == other_cases
    assert wanted.isdisjoint(other_wanted)


@settings(max_examples=40)
@given(studies(), st.randoms(use_true_random=False))
def test_names_and_orders_change_no_id(data, random):
    other = copy.deepcopy(data)
    other["study"]["name"] = "another"
    for kind in ("soil", "track", "train", "unevenness"):
        renamed = {name: f"{index}-{name}" for index, name in enumerate(other[kind])}
        other[kind] = {renamed[name]: table for name, table in reversed(other[kind].items())}
        other["sweep"][kind] = [renamed[name] for name in other["sweep"][kind]]
        random.shuffle(other["sweep"][kind])
    renamed = {name: f"v-{name}" for name in other["vehicle"]}
    other["vehicle"] = {renamed[name]: table for name, table in other["vehicle"].items()}
    for train in other["train"].values():
        for group in train["vehicles"]:
            group["vehicle"] = renamed[group["vehicle"]]
    for values in (
        other["sweep"]["speed_kmh"],
        other["receivers"]["offsets_m"],
        other["approaches"]["compare"],
    ):
        random.shuffle(values)
    other["sweep"] = dict(reversed(other["sweep"].items()))
    assert ids(dict(reversed(other.items()))) == ids(data)


@settings(max_examples=10)
@given(data=studies())
def test_the_directory_changes_no_task(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("plans")
    data["frequency"] = {"minimum_hz": 8.0, "maximum_hz": 10.0}
    resolved = study.resolve(data)
    one, other = (prepare(resolved, folder / name).plan for name in ("one", "other"))
    assert one.tasks.keys() == other.tasks.keys()
    assert one.missing == other.missing


def test_the_number_of_workers_enters_no_id(tmp_path, monkeypatch):
    from tests.sweep.small import STUDY, invoke

    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    planned = []
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")

    def execute(request, directory, launch, *_):
        planned.append((launch.workers, request))
        return 0

    monkeypatch.setattr("sweep.driver.execute", execute)
    for workers in (0, 1, 3):
        result = invoke("run", tmp_path / "small.toml", "--out", tmp_path / "out", "--workers", workers)
        assert result.exit_code == 0, result.output
    assert [workers for workers, _ in planned] == [0, 1, 3]
    assert len({tuple(request.plan.units) for _, request in planned}) == 1
    assert len({tuple(request.plan.tasks) for _, request in planned}) == 1
