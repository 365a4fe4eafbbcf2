import pytest

from sweep import plan
from sweep.unit import unit_of
from tests.sweep import toy


def positions(made):
    return {unit.id: index for index, task in enumerate(made.tasks.values()) for unit in task.units}


def test_everything_is_missing_at_first():
    wanted = [toy.total(1, 2), toy.total(2, 3)]
    work_plan = plan.make(wanted, set())
    assert work_plan.missing == work_plan.units.keys()
    assert len(work_plan.units) == 5
    assert sorted(len(task.units) for task in work_plan.tasks.values()) == [
        1,
        1,
        1,
        2,
    ]  # 2 and 3 are computed together


def test_a_task_stands_after_those_it_needs():
    work_plan = plan.make([toy.total(*range(start, start + 5)) for start in range(7)], set())
    seen = set()
    for task in work_plan.tasks.values():
        assert task.after <= seen
        seen.add(task.key)
    assert seen == work_plan.tasks.keys()


def test_what_is_there_is_not_planned():
    wanted = toy.total(1, 2, 3)
    work_plan = plan.make([wanted], {toy.square(2).id})
    assert work_plan.missing == {wanted.id, toy.square(1).id, toy.square(3).id}


def test_what_only_a_finished_unit_needs_is_not_planned():
    done, missing = toy.total(1, 2), toy.total(2, 3)
    work_plan = plan.make([done, missing], {done.id})
    assert work_plan.missing == {missing.id, toy.square(2).id, toy.square(3).id}


def test_nothing_is_planned_when_all_is_there():
    wanted = [toy.total(1, 2), toy.total(2, 3)]
    assert plan.make(wanted, {unit.id for unit in wanted}).tasks == {}


def test_the_closure_names_all_that_a_unit_rests_on():
    wanted = toy.total(1, 2)
    work_plan = plan.make([wanted], {wanted.id})
    assert set(work_plan.closure[wanted.id]) == {wanted.id, toy.square(1).id, toy.square(2).id}
    assert work_plan.closure[wanted.id][-1] == wanted.id


def test_the_same_request_makes_the_same_tasks():
    one, other = ([toy.total(1, 2), toy.total(3, 4)] for _ in range(2))
    assert plan.make(one, set()).tasks.keys() == plan.make(other, set()).tasks.keys()


def test_keys_have_the_form_that_dask_groups_by():
    from dask.utils import key_split

    work_plan = plan.make([toy.total(1, 2), toy.total(3, 4)], set())
    assert {key_split(key) for key in work_plan.tasks} == {"square", "total"}


def test_tasks_that_wait_for_each_other_are_an_error():
    class Circular(toy.Square):
        def together(self):
            return 1  # 1 and 2 in one task, which then needs one that needs it

        def needs(self):
            return [Sum(numbers=(2.0,))] if self.number == 1.0 else []

    class Sum(toy.Total):
        def needs(self):
            return [Circular(number=number) for number in self.numbers]

    with pytest.raises(ValueError, match="wait for each other"):
        plan.make([unit_of(Sum(numbers=(1.0,)))], set())


def test_the_part_of_a_plan_that_rests_on_some_units():
    wanted = [toy.total(1, 2), toy.total(3, 9), toy.total(4, 5)]  # 2 and 3 are squared by one task
    work_plan = plan.make(wanted, set())
    part = work_plan.resting_on({toy.square(1).id})
    assert part.missing == {wanted[0].id} | {toy.square(number).id for number in (1, 2, 3)}
    assert all(task.after <= part.tasks.keys() for task in part.tasks.values())
    assert work_plan.resting_on(set()).tasks == {}


def test_a_complete_plan_has_also_what_finished_units_rest_on():
    wanted = toy.total(1, 2)
    work_plan = plan.make([wanted], {wanted.id, toy.square(1).id}, complete=True)
    assert work_plan.missing == {toy.square(2).id}
