"""From the wanted units to the missing tasks, in an order in which they can run."""

import hashlib
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, field, replace

from sweep.unit import Unit


@dataclass(frozen=True)
class Task:
    """Units that are computed together, and the tasks that must be done before."""

    key: str
    units: tuple[Unit, ...]
    after: frozenset[str]


@dataclass(frozen=True)
class Plan:
    """Tasks by key, each after those it needs, and every unit that the request rests on.

    Attributes
    ----------
    tasks
        What is missing.
    units
        All units by id, present or missing.
    closure
        Per wanted unit, by id: the ids of all units that it rests on, itself last.
    """

    tasks: Mapping[str, Task]
    units: Mapping[str, Unit]
    closure: Mapping[str, tuple[str, ...]]
    missing: Set[str] = field(default_factory=frozenset)

    def resting_on(self, identities: Set[str]) -> "Plan":
        """Return the plan restricted to wanted units that rest on one of these units."""
        wanted = {
            other
            for closure in self.closure.values()
            if not identities.isdisjoint(closure)
            for other in closure
        }
        keys: set[str] = set()
        for key in reversed(list(self.tasks)):  # backwards, so that what a task needs is kept too
            task = self.tasks[key]
            if key in keys or any(unit.id in wanted for unit in task.units):
                keys |= {key, *task.after}
        tasks = {key: task for key, task in self.tasks.items() if key in keys}
        return replace(
            self, tasks=tasks, missing=frozenset(unit.id for task in tasks.values() for unit in task.units)
        )


def make(wanted: Iterable[Unit], present: Set[str], complete: bool = False) -> Plan:
    """Plan what is missing of the wanted units and of all they need.

    Parameters
    ----------
    wanted
        The units whose results are asked for.
    present
        Ids of the units that are done.
    complete
        Include missing units that only finished units need.
    """
    needs: dict[str, tuple[str, ...]] = {}
    units: dict[str, Unit] = {}

    def visit(unit: Unit) -> None:
        if unit.id in units:
            return
        needed = unit.needs()
        for other in needed:
            visit(other)
        needs[unit.id] = tuple(other.id for other in needed)
        units[unit.id] = unit  # after its needs, so that this order can be run

    roots = list(dict.fromkeys(wanted))
    for unit in roots:
        visit(unit)
    closure = {unit.id: _closure(unit.id, needs) for unit in roots}

    missing: set[str] = set()
    for identity in reversed(units):
        # A unit is missing if it is wanted, or needed by a missing one; those come later and are decided.
        if identity not in present and (complete or identity in closure or identity in missing):
            missing.add(identity)
        if identity in missing:
            missing.update(other for other in needs[identity] if other not in present)
    return Plan(_tasks(units, needs, missing), units, closure, frozenset(missing))


def _closure(identity: str, needs: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """Return the ids of all that a unit rests on, each after those that it needs."""
    closure: dict[str, None] = {}

    def visit(one: str) -> None:
        if one not in closure:
            for other in needs[one]:
                visit(other)
            closure[one] = None

    visit(identity)
    return tuple(closure)


def _tasks(
    units: Mapping[str, Unit],
    needs: Mapping[str, tuple[str, ...]],
    missing: Set[str],
) -> dict[str, Task]:
    """Gather the missing units into tasks, in an order in which they can run."""
    groups: dict[object, list[Unit]] = {}
    for identity, unit in units.items():
        if identity in missing:
            groups.setdefault((type(unit.stage), unit.stage.together()), []).append(unit)
    keys: dict[str, str] = {}
    for group in groups.values():
        digest = hashlib.sha256("".join(unit.id for unit in group).encode()).hexdigest()[:32]
        for unit in group:
            keys[unit.id] = f"{group[-1].stage_name}-{digest}"
    tasks: dict[str, Task] = {}
    for group in groups.values():
        key = keys[group[0].id]
        after = {keys[other] for unit in group for other in needs[unit.id] if other in missing}
        tasks[key] = Task(key, tuple(group), frozenset(after - {key}))
    return _sort(tasks)


def _sort(tasks: Mapping[str, Task]) -> dict[str, Task]:
    """Return tasks sorted so that each stands after those it needs.

    Raises
    ------
    ValueError
        If tasks depend on each other in a circle: an error in how stages are grouped.
    """
    done: dict[str, Task] = {}
    waiting = dict(tasks)
    while waiting:
        ready = [key for key, task in waiting.items() if task.after <= done.keys()]
        if not ready:
            raise ValueError(f"{len(waiting)} tasks wait for each other")
        for key in ready:
            done[key] = waiting.pop(key)
    return done
