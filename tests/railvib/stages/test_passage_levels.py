"""The stage of levels of passages, on a small case by each approach."""

import numpy as np
import pytest

from railvib.parameters.approach import APPROACHES
from railvib.parameters.metric import METRICS
from railvib.stages import STAGES, evaluate, stage_of
from railvib.stages.passage_levels import PassageLevelsOfCase
from tests.railvib.stages.test_graph import case

BAND = (7.943282347242816, 10.0, 12.589254117941675)
QUANTILES = (0.05, 0.5, 0.95)


def stage(approach, **changes):
    fields = case(band=BAND, speed=30.0)
    del fields["averaging"]
    if approach != "fe-be":
        del fields["cross_section"]
    levels = {"metrics": METRICS, "quantiles": QUANTILES, "passages": 64, "seed": 1}
    return PassageLevelsOfCase(approach=approach, **{**fields, **levels, **changes})


@pytest.fixture(scope="module")
def results():
    stages = {approach: stage(approach) for approach in APPROACHES if approach != "fe-be"}
    computed = evaluate(list(stages.values()))
    return {approach: computed[each] for approach, each in stages.items()}


@pytest.mark.parametrize("approach", APPROACHES)
def test_its_inputs_describe_it(approach):
    one = stage(approach)
    assert STAGES[type(one).__name__] is type(one)
    plain = {
        name: value.model_dump() if hasattr(value, "model_dump") else value
        for name, value in one.inputs().items()
    }
    assert stage_of(one.name, plain) == one
    assert one != stage(approach, seed=2)


def value_of(levels, metric, statistic, row):
    chosen = (levels.metric == metric) & (levels.statistic == statistic)
    return levels.value[chosen][row]


@pytest.mark.parametrize("approach", ["moving-roughness", "moving-roughness-uncorrelated", "full"])
def test_rows(results, approach):
    levels = results[approach]
    keys = list(zip(levels.receiver, levels.metric, levels.statistic, strict=True))
    assert len(set(keys)) == len(keys)
    assert np.all(np.isfinite(levels.value) & (levels.value > 0.0))
    for row in (0, 1):  # rail, and ground
        for metric in (*METRICS[:5], "third-octave-max-fast 10 Hz"):
            low, middle, high = (value_of(levels, metric, f"q{each:g}", row) for each in QUANTILES)
            assert low < middle < high
            assert low < value_of(levels, metric, "mean", row) < high
        peak, fast, slow = (
            value_of(levels, name, "q0.5", row) for name in ("ppv", "v-max-fast", "v-max-slow")
        )
        assert peak > fast > slow


def test_moving_roughness_by_axle_is_moving_roughness(results):
    one, other = results["moving-roughness-by-axle"], results["moving-roughness"]
    np.testing.assert_array_equal(one.value, other.value)


def test_approaches_agree_within_a_few_decibels(results):
    """At this speed Doppler's shift is small, and these bands are above the comb's first teeth."""
    for metric in METRICS[:5]:
        full, moving = (value_of(results[name], metric, "q0.5", 1) for name in ("full", "moving-roughness"))
        assert abs(20.0 * np.log10(full / moving)) < 4.0, metric


def test_closed_forms_sample_nothing(results):
    """Medians are within 1.5 dB, in one-third octaves 3 dB; of doses they know the expectation only."""
    one = stage("full", passages=0)
    closed = evaluate([one])[one]
    for metric in (*METRICS[:4], "third-octave-max-fast 10 Hz"):
        values = (value_of(each, metric, "q0.5", 1) for each in (closed, results["full"]))
        limit = 3.0 if metric.startswith("third-octave") else 1.5
        assert abs(20.0 * np.log10(np.divide(*values))) < limit, metric
    assert set(closed.statistic[closed.metric == "vdv"]) == {"expected"}


def test_amounts_grow_with_what_is_asked():
    one = stage("full").work().amounts
    more = stage("full", passages=1024).work().amounts
    assert more["sampled"] == 4 * one["sampled"]
    assert stage("moving-roughness-uncorrelated").memory() > stage("moving-roughness").memory()
