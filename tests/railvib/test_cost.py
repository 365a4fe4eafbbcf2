import contextlib
from functools import partial
from itertools import count

import pytest

from railvib import cost


def test_stages_of_one_name_add_up():
    with cost.collect() as costs:
        for number in (3, 4):
            with cost.stage("fit") as spent:
                spent.evaluations += number
                spent.kernel_calls += 1
        with cost.stage("bands"):
            sum(range(100_000))
    fit, bands = costs
    assert (fit.stage, fit.evaluations, fit.kernel_calls) == ("fit", 7, 2)
    assert bands.wall_s > 0.0
    assert bands.cpu_s > 0.0
    assert bands.peak_rss_bytes > 2**20


def test_a_stage_inside_another_is_taken_out_of_that(monkeypatch):
    """By clocks that go on by one each time that they are looked at."""
    for name in ("perf_counter", "process_time"):
        monkeypatch.setattr(cost.time, name, partial(next, count()))
    with cost.collect() as costs:
        with cost.stage("passage"):
            for _ in range(2):
                with cost.stage("load"):
                    pass
        with cost.stage("bands"):
            pass
    assert {each.stage: (each.wall_s, each.cpu_s) for each in costs} == {
        "load": (2, 2),
        "passage": (3, 3),
        "bands": (1, 1),
    }


def test_a_stage_that_raises_is_counted():
    with cost.collect() as costs:
        with contextlib.suppress(ZeroDivisionError), cost.stage("fit") as spent:
            spent.evaluations += 1
            spent.evaluations /= 0
    assert [(each.stage, each.evaluations) for each in costs] == [("fit", 1)]


def test_without_a_collector_nothing_is_kept():
    with cost.stage("fit") as spent:
        spent.evaluations += 1
    with cost.collect() as costs:
        pass
    assert costs == []


def test_an_inner_collector_keeps_its_own():
    with cost.collect() as outer:
        with cost.collect() as inner, cost.stage("inner"):
            pass
        with cost.stage("outer"):
            pass
    assert [each.stage for each in inner] == ["inner"]
    assert [each.stage for each in outer] == ["outer"]


def test_collecting_ends_with_an_error():
    def compute():
        with cost.collect(), cost.stage("fit"):
            raise KeyError("fit")

    with pytest.raises(KeyError):
        compute()
    with cost.collect() as costs:
        pass
    assert costs == []
