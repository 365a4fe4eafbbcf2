"""From the tables of a study to its cases."""

import warnings

import pytest
from hypothesis import given
from hypothesis import strategies as st

from railvib import library
from railvib.errors import InputError, PlausibilityWarning
from sweep import study
from tests.sweep.study.tables import LAYER, PAPER, changed, paper

speeds = st.lists(st.floats(10.0, 400.0), min_size=1, max_size=4, unique=True)


def ids(tables):
    return {case.case_id for case in study.resolve(tables).cases()}


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
        ("sweep.soil", ["grebi"], "sweep.soil = 'grebi': is unknown; the nearest known is 'greby'"),
        ("soil.mine", 3, "soil.mine = 3: must be a table of parameters"),
        ("soil.mine.layers", [], "soil.mine.layers = []: must have at least one value"),
        ("soil.mine.layers", [LAYER | {"thickness_m": 3}], "soil.mine.layers[0].thickness_m = 3 m: the last"),
        ("soil.mine.layers", [LAYER, LAYER], "soil.mine.layers[0].thickness_m: is missing"),
        (
            "soil.mine.layers",
            [LAYER | {"los_factor": 1}],
            "soil.mine.layers[0].los_factor: unknown key; did you",
        ),
        (
            "soil.mine.layers",
            [LAYER | {"density_kg_m3": -1}],
            "soil.mine.layers[0].density_kg_m3 = -1 kg/m³: ",
        ),
        (
            "soil.mine.layers",
            [LAYER | {"thickness_m": True}],
            "soil.mine.layers[0].thickness_m = True: should",
        ),
        (
            "soil.mine.layers",
            [LAYER | {"thickness_m": "3.0"}],
            "layers[0].thickness_m = '3.0': should be a valid",
        ),
        ("soil.mine.layers", [LAYER | {"thickness_m": 1e-6}], "layers[0].thickness_m = 1e-06 m: should be"),
        (
            "soil.mine.layers",
            [LAYER | {"loss_factor": -0.1}],
            "soil.mine.layers[0].loss_factor = -0.1: should",
        ),
        ("soil.mine.layers", [{"density_kg_m3": 1800}], "soil.mine.layers[0].shear_speed_m_s: is missing"),
        (
            "soil.mine.layers",
            [LAYER | {"dilatational_speed_m_s": 110}],
            "soil.mine.layers[0].dilatational_speed_m_s = 110 m/s: must exceed sqrt(4/3) of shear_speed_m_s",
        ),
        ("soil.mine.layers", [LAYER | {"poisson_ratio": 0.3}], "give dilatational_speed_m_s = 187.083 m/s"),
        ("train.mine.vehicles", ["regin"], "vehicle = 'regin': is unknown; the nearest known is 'regina'"),
        ("train.mine", {"vehicle": "regina", "number": 10**9}, "train.mine.number = 1000000000: must be"),
        ("train.mine.vehicles", ["regina"] * 10**5, "train.mine.vehicles: more than 1000 vehicles"),
        (
            "cross_section.elements",
            10**3,
            "cross_section.elements = 1000: should be less than or equal to 64",
        ),
        ("cross_section.bed", "columns", 'cross_section.contact = "bonded": columns carry no horizontal'),
    ],
)
def test_wrong_definitions_are_refused_in_one_line(path, value, message):
    with pytest.raises(InputError) as refusal:
        study.resolve(changed(path, value))
    assert message in str(refusal.value)
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 500


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("sweep.speed_kmh", [150, 5], "sweep.speed_kmh = 5 km/h: trains run at 10 km/h or more"),
        (
            "soil.mine.layers",
            [LAYER | {"density_kg_m3": 1.75}],
            "soil.mine.layers[0].density_kg_m3 = 1.75 kg/m³",
        ),
        (
            "track.mine",
            {**library.entry("track", "ballasted-paper").parameters, "rail_mass_kg_m": 60},
            "track.mine.rail_mass_kg_m = 60 kg/m: below 80 kg/m, as of one rail",
        ),
        (
            "vehicle.mine",
            {**library.entry("vehicle", "regina").parameters, "axle_load_n": 14e3},
            "vehicle.mine.axle_load_n = 14000 N: the four axles carry 5.6e+04 N",
        ),
    ],
)
def test_what_is_implausible_is_warned_about_with_its_place(path, value, message):
    with pytest.warns(PlausibilityWarning) as caught:
        study.resolve(changed(path, value))
    assert [str(warning.message)[: len(message)] for warning in caught] == [message]


def test_the_papers_study_is_plausible():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        study.load(PAPER)


def test_inline_definitions_stand_before_the_library():
    tables = changed("soil.greby", {"layers": [LAYER]})
    assert study.resolve(tables).objects["soil"]["greby"].layers[0].shear_speed == 100.0


def test_an_inline_copy_of_the_library_is_the_same_case():
    entry = library.entry("soil", "greby").parameters
    tables = changed("soil", {"mine": dict(entry)})
    tables["sweep"]["soil"] = ["mine", "horstwalde"]
    assert ids(tables) == ids(paper())


@pytest.mark.parametrize("kind", ["soil", "track", "train", "unevenness"])
def test_two_names_for_equal_things_are_labels_of_one_case(kind):
    tables = paper()
    (name, *_) = tables["sweep"][kind]
    entry = dict(library.entry(kind, name).parameters)
    tables["sweep"][kind] = [name, "mine"]
    tables[kind] = {"mine": entry}
    one = changed(f"sweep.{kind}", [name])
    cases = list(study.resolve(tables).cases())
    assert {case.case_id for case in cases} == ids(one)
    assert len(cases) == len(ids(one))
    for case in cases:
        assert [getattr(label, kind) for label in case.labels] == [name, "mine"]
        assert case.labels[0] == (case.soil, case.track, case.train, case.unevenness, case.speed_kmh)


def test_two_spellings_of_a_name_are_one():
    composed, decomposed = "M\u00fcnchen", "Mu\u0308nchen"
    tables = changed("soil", {decomposed: {"layers": [LAYER]}})
    tables["sweep"]["soil"] = [composed, decomposed]
    assert [case.soil for case in study.resolve(tables).cases()] == [composed]


def test_a_study_spelt_out_is_the_same_study():
    resolved = study.resolve(changed("study.title", "The paper – a comparison"))
    again = study.resolve(resolved.document())
    assert [case.case_id for case in again.cases()] == [case.case_id for case in resolved.cases()]
    assert again.document() == resolved.document()
    assert again.study.study.title == "The paper – a comparison"


@given(speeds, st.randoms())
def test_order_and_names_change_no_id(values, random):
    shuffled = random.sample(values, len(values))
    one, other = changed("sweep.speed_kmh", values), changed("sweep.speed_kmh", shuffled)
    other["study"] = {"name": "another", "title": "Another one"}
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
