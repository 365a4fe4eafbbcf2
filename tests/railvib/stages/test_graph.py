"""The graph of stages: what a stage is, and that evaluating the graph computes each stage once."""

import pickle

import numpy as np
import pytest

from railvib import library
from railvib.errors import InputError
from railvib.parameters.approach import APPROACHES
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.receiver import RAIL, Receiver
from railvib.parameters.vehicle import Train
from railvib.stages import STAGES, case_spectra, evaluate, stage_of
from railvib.stages.fe_be_table import FeBeTable
from railvib.stages.passage_levels import PassageLevelsOfCase
from railvib.stages.transfer_table import TransferTable


def case(**changes):
    return {
        "ground": library.load("soil", "horstwalde"),
        "track": library.load("track", "ballasted-paper"),
        "train": Train(vehicles=(library.load("vehicle", "regina"),)),
        "unevenness": library.load("unevenness", "german-low"),
        "speed": 10.0,
        "band": (7.943282347242816, 10.0),
        "receivers": (RAIL, Receiver(8.0)),
        "averaging": ("line", "train"),
        "tolerance": 1e-3,
        "cross_section": CrossSection(),
        **changes,
    }


def closure(stage):
    """Return a stage and all that it rests on."""
    return {stage}.union(*(closure(need) for need in stage.needs()))


@pytest.mark.parametrize("approach", APPROACHES)
def test_every_stage_is_the_one_that_its_inputs_describe(approach):
    """Inputs in plain form make an equal stage: so an id made of them leaves nothing out."""
    for stage in closure(case_spectra(approach, **case())):
        assert STAGES[type(stage).__name__] is type(stage)
        plain = {
            name: value.model_dump() if hasattr(value, "model_dump") else value
            for name, value in stage.inputs().items()
        }
        again = stage_of(stage.name, plain)
        assert again == stage
        assert hash(again) == hash(stage)


def test_all_stages_of_the_registry_are_needed_by_some_approach():
    names = {
        type(stage).__name__ for approach in APPROACHES for stage in closure(case_spectra(approach, **case()))
    }
    assert {*names, PassageLevelsOfCase.__name__} == STAGES.keys()


def test_stages_differ_by_any_input():
    stage = case_spectra("full", **case())
    others = [
        {"speed": 11.0},
        {"tolerance": 1e-4},
        {"receivers": (RAIL,)},
        {"ground": library.load("soil", "greby")},
        {"refinement": 2},
    ]
    assert len({stage, *(case_spectra("full", **case(**change)) for change in others)}) == 6
    assert stage == pickle.loads(pickle.dumps(stage))


def test_only_the_fe_be_model_takes_a_cross_section():
    other = CrossSection(layer_height=0.5)
    for approach in APPROACHES:
        same = case_spectra(approach, **case()) == case_spectra(approach, **case(cross_section=other))
        assert same == (approach != "fe-be")
    tables = {type(stage) for stage in closure(case_spectra("fe-be", **case()))}
    assert FeBeTable in tables
    assert TransferTable not in tables


def test_refinement_reaches_every_stage():
    for approach in APPROACHES:
        for stage in closure(case_spectra(approach, **case(refinement=2))):
            assert stage.refinement == 2


def test_each_stage_is_computed_once(monkeypatch):
    calls = []
    compute = TransferTable.compute_together.__func__

    def counted(cls, stages, load):
        calls.extend(stages)
        yield from compute(cls, stages, load)

    monkeypatch.setattr(TransferTable, "compute_together", classmethod(counted))
    wanted = [case_spectra(approach, **case()) for approach in ("moving-roughness", "full")]
    results = evaluate(wanted)
    assert set(results) == closure(wanted[0]) | closure(wanted[1])
    assert len(calls) == len(set(calls)) > 3
    assert np.isfinite(results[wanted[0]].psd).all()


def test_a_stage_that_no_class_takes_is_refused():
    with pytest.raises(InputError, match="transfer: no stage takes the inputs block, colour"):
        stage_of("transfer", {"block": 1, "colour": "red"})


def test_estimates_are_positive():
    for approach in APPROACHES:
        for stage in closure(case_spectra(approach, **case())):
            assert stage.nbytes() > 0
            assert stage.memory() > 0
            assert all(amount >= 0.0 for amount in stage.work().amounts.values())
