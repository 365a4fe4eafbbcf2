"""Units of work: one stage, with the id under which its result is stored and recorded.

A module that offers stages to the engine has a mapping ``STAGES`` from names to classes of stages, and a
function ``warm_up``; that of the product is `railvib.stages`.
"""

import importlib
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any

from railvib.stages.stage import Scope, Stage, Work
from sweep import identity

REMEMBERED = 4096
"""Units that planning caches, as cases share them."""

Inputs = Mapping[str, Any]


class Unit:
    """One result to compute and store. Two with the same id are equal."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage

    @property
    def stage_name(self) -> str:
        """Name of the stage, under which its results are stored; the `kind` of their records."""
        return self.stage.name

    @property
    def scope(self) -> Scope:
        """The most that the unit depends on: the ground, the speed, or the whole case."""
        return self.stage.scope

    @cached_property
    def inputs(self) -> Inputs:
        """The inputs in canonical form."""
        inputs: Inputs = identity.canonical(self.stage.inputs())
        return inputs

    @cached_property
    def id(self) -> str:
        """The unit's id."""
        return identity.unit_id(self.stage_name, self.inputs)

    def needs(self) -> "list[Unit]":
        """Return the units that it is computed from."""
        return [unit_of(stage) for stage in self.stage.needs()]

    def __eq__(self, other: object) -> bool:
        """Return whether the other one is a unit of the same id."""
        return isinstance(other, Unit) and self.id == other.id

    def __hash__(self) -> int:
        """Return the hash of the id."""
        return hash(self.id)

    def __repr__(self) -> str:
        """Return stage and id."""
        return f"Unit({self.stage_name}/{self.id})"


@lru_cache(REMEMBERED)
def unit_of(stage: Stage) -> Unit:
    """Return the unit of a stage."""
    return Unit(stage)


Load = Callable[[Unit], Any]
"""Reads the result of a unit that is done."""


def work(task: Sequence[Unit]) -> Work:
    """Return the amounts of work of units that are computed together."""
    return type(task[0].stage).work_together([unit.stage for unit in task])


def registry(module: str) -> Mapping[str, type[Stage]]:
    """Return the classes of stages that a module offers, by name."""
    stages: Mapping[str, type[Stage]] = importlib.import_module(module).STAGES
    return stages


def stage_class(unit: Unit, stages: Mapping[str, type[Stage]]) -> type[Stage]:
    """Return the class in a registry that computes a unit.

    Raises
    ------
    KeyError
        If the registry does not have it.
    """
    return stages[type(unit.stage).__name__]
