"""A stage of the computation: its physical inputs, what it needs, how it is computed, and what that takes.

Everything that a result depends on is a field of its stage, so that an identity made of the fields cannot
leave anything out. Stages that differ in a receiver only can be computed together.

The module of a stage imports what planning takes, and the physics where it computes: a driver that plans
loads no compiled kernels.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from functools import cache, cached_property
from operator import attrgetter
from typing import Any, ClassVar, Literal, Self

from pydantic import ConfigDict, TypeAdapter

Scope = Literal["ground", "speed", "case"]

FLOAT, COMPLEX = 8, 16
"""Bytes of a number."""


@dataclass(frozen=True)
class Work:
    """Amounts of work that processor time grows with.

    They need not be exact: the same formulas count the work from which rates are measured, so that a constant
    error in a formula is in the rate as well.

    Attributes
    ----------
    sort
        Tasks of one sort share their rates.
    amounts
        Amounts by name.
    by_cost
        For parts whose cost is measured apart (see `railvib.cost`): the amounts that this cost grows with.
        What else a task costs grows with the other amounts.
    """

    sort: str
    amounts: Mapping[str, float]
    by_cost: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


Load = Callable[["Stage"], Any]
"""Returns the result of a stage that is done."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Stage(ABC):
    """Inputs of one result. Stages of equal inputs are equal.

    Attributes
    ----------
    name
        Name under which results are stored.
    at_once
        How many stages of a group are in memory at once, at most; all of them if None.
    grows_with
        Keys of a study, without their section, with whose values the number of such stages grows.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")
    name: ClassVar[str]
    at_once: ClassVar[int | None] = None
    grows_with: ClassVar[tuple[str, ...]] = ()

    @classmethod
    @abstractmethod
    def result_type(cls) -> type:
        """Return the frozen dataclass of arrays that is computed."""

    @property
    @abstractmethod
    def scope(self) -> Scope:
        """What it depends on at most: ground and track, the speed as well, or the whole case."""

    def needs(self) -> "Sequence[Stage]":
        """Return the stages whose results it is computed from."""
        return ()

    @abstractmethod
    def compute(self, load: Load) -> Any:
        """Compute the result from the results of what it needs."""

    @classmethod
    def compute_together(cls, stages: Sequence[Self], load: Load) -> Iterator[Mapping[Self, Any]]:
        """Compute stages of one group; yield their results in batches as they come."""
        for stage in stages:
            yield {stage: stage.compute(load)}

    @classmethod  # noqa: B027  most stages have no such kernels
    def compile(cls) -> None:
        """Compile the kernels that `railvib.stages.warm_up` leaves out, if it needs such ones."""

    def together(self) -> Hashable:
        """Return what it shares with all stages of its group."""
        return self

    def label(self) -> str | None:
        """Return what tells its result from others stored with it; None if it is stored alone."""
        return None

    @abstractmethod
    def nbytes(self) -> int:
        """Estimate the bytes of its result."""

    @abstractmethod
    def memory(self) -> int:
        """Estimate the bytes that computing it takes beyond what an idle process has."""

    def memory_grows_with(self) -> str | None:
        """Return the axis of a study that makes its memory large, where that is neither band nor offset."""
        return None

    def work(self) -> Work:
        """Return its amounts of work."""
        return Work(self.name, {"units": 1.0})

    @classmethod
    def work_together(cls, stages: Sequence[Self]) -> Work:
        """Return the amounts of work of a group."""
        parts = [stage.work() for stage in stages]
        first = parts[0]
        amounts = {name: sum(part.amounts[name] for part in parts) for name in first.amounts}
        return Work(first.sort, amounts, first.by_cost)

    def inputs(self) -> dict[str, Any]:
        """Return the fields by name, without those that have their default value."""
        values = {each.name: (getattr(self, each.name), each.default) for each in fields(self)}
        return {
            name: value for name, (value, default) in values.items() if default is MISSING or value != default
        }

    @classmethod
    def from_inputs(cls, inputs: Mapping[str, Any]) -> Self:
        """Return the stage of inputs in plain form, as records have them.

        Raises
        ------
        pydantic.ValidationError
            If they are not the inputs of such a stage.
        """
        stage: Self = TypeAdapter(cls).validate_python(dict(inputs))
        return stage

    @cached_property
    def _values(self) -> tuple[Any, ...]:
        values: tuple[Any, ...] = _values_of(type(self))(self)
        return values

    @cached_property
    def _hash(self) -> int:
        return hash(self._values)

    def __eq__(self, other: object) -> bool:
        """Return whether the other one is of the same class and has equal inputs."""
        return self is other or (
            isinstance(other, Stage) and self._hash == other._hash and self._values == other._values
        )

    def __hash__(self) -> int:
        """Return the hash of all inputs."""
        return self._hash

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields: a hash of texts holds in one process only."""
        return {name: getattr(self, name) for name in _names(type(self))}


@cache
def _names(stage: type[Stage]) -> tuple[str, ...]:
    return tuple(each.name for each in fields(stage))


@cache
def _values_of(stage: type[Stage]) -> Callable[[Stage], Any]:
    return attrgetter(*_names(stage), "__class__")  # two names at least: a single one gives no tuple
