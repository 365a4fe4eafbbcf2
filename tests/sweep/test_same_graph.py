"""`railvib.predict` and a run evaluate one graph of stages: what breaks one breaks both."""

import tomllib

import pytest

import railvib
from railvib import prediction
from railvib.stages import STAGES
from railvib.stages.quasi_static import QuasiStaticResponse
from sweep import plan, study
from sweep.running.task import Place, execute
from sweep.wanted import spectra_unit
from sweep.workers.launch import STAGES as MODULE
from tests.sweep.small import STUDY


def predict(resolved, case):
    return railvib.predict(
        *(resolved.objects[kind][getattr(case, kind)] for kind in ("soil", "track", "train", "unevenness")),
        case.speed_kmh / 3.6,
        offsets=[8.0],
        approaches=("moving-roughness", "full"),
        minimum_frequency=4.0,
        maximum_frequency=8.0,
        tolerance=1e-3,
    )


def run(resolved, case, directory):
    """Compute the case as a worker does; return the stages computed and the errors of tasks that failed."""
    wanted = [spectra_unit(resolved, case, approach) for approach in ("moving-roughness", "full")]
    place = Place(str(directory), "run", MODULE)
    stages, errors = set(), []
    for task in plan.make(wanted, set()).tasks.values():
        outcome = execute(task.key, task.units, place)
        stages |= {unit.stage for unit in task.units}
        errors += [outcome.error] if outcome.status == "failed" else []
    return stages, errors


def test_both_evaluate_the_same_stages(tmp_path, monkeypatch):
    resolved = study.resolve(tomllib.loads(STUDY))
    (case,) = resolved.cases()
    predicted = []
    evaluate = prediction.evaluate
    monkeypatch.setattr(
        "railvib.prediction.evaluate", lambda stages: predicted.append(evaluate(stages)) or predicted[-1]
    )
    predict(resolved, case)
    stages, errors = run(resolved, case, tmp_path)
    assert errors == []
    assert stages == set(predicted[0])


def test_a_stage_that_is_taken_from_the_registry_breaks_both(tmp_path, monkeypatch):
    resolved = study.resolve(tomllib.loads(STUDY))
    (case,) = resolved.cases()
    monkeypatch.delitem(STAGES, QuasiStaticResponse.__name__)
    with pytest.raises(KeyError, match="QuasiStaticResponse"):
        predict(resolved, case)
    _, errors = run(resolved, case, tmp_path)
    assert any("QuasiStaticResponse" in error for error in errors)
