import pickle

import pytest

import railvib
from sweep import identity
from sweep.unit import registry, stage_class, unit_of, work
from tests.sweep import toy


def test_a_unit_is_its_stage_and_its_inputs():
    assert toy.square(2) == toy.square(2.0)
    assert toy.square(2) != toy.square(3)
    assert toy.square(2).id == identity.unit_id("square", {"number": 2.0})
    assert identity.unit_id("total", {"number": 2.0}) != toy.square(2).id


def test_another_version_of_the_model_makes_other_units(monkeypatch):
    before = identity.unit_id("square", {"number": 2.0})
    monkeypatch.setattr(railvib, "MODEL_VERSION", "of tomorrow")
    assert identity.unit_id("square", {"number": 2.0}) != before


def test_needs_are_units_of_the_stages_needed():
    assert toy.total(2, 1).needs() == [toy.square(1), toy.square(2)]


def test_a_unit_keeps_its_id_in_another_process():
    unit = toy.total(1, 2)
    again = pickle.loads(pickle.dumps(unit))
    assert again == unit
    assert again.id == unit.id


def test_the_registry_says_who_computes_a_unit():
    stages = registry(toy.__name__)
    assert stage_class(toy.square(1), stages) is toy.Square
    with pytest.raises(KeyError):
        stage_class(toy.square(1), {})


def test_work_of_units_is_summed():
    units = [toy.square(2), toy.square(3)]
    assert work(units).amounts == {"units": 2.0}
    assert unit_of(toy.Square(number=2.0)) is unit_of(toy.Square(number=2.0))
