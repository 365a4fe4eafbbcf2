"""Units of work: what one is, and what the engine must know of a kind of unit to plan and run it.

A unit is one stored result with one record. Its inputs are plain canonical data that hold everything its
result depends on, and computing starts from them alone: so an identity cannot leave out what a result depends
on. A module that offers work to the engine has a mapping `KINDS` from names to kinds; `sweep.units` is the
product's.
"""

import importlib
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

from sweep import identity


class AccuracyWarning(UserWarning):
    """A result that stays behind the accuracy asked for; the message gives both, and goes to the record."""


Inputs = Mapping[str, Any]
Scope = Literal["ground", "speed", "case"]


@dataclass(frozen=True, eq=False)
class Unit:
    """One thing to compute and store: a kind and its canonical inputs. Two with the same id are equal."""

    kind: str
    inputs: Inputs

    @classmethod
    def of(cls, kind: str, **inputs: Any) -> "Unit":
        """Build a unit from physical objects, numbers and texts."""
        return cls(kind, identity.canonical(inputs))

    @cached_property
    def id(self) -> str:
        """The unit's id."""
        return identity.unit_id(self.kind, self.inputs)

    def __eq__(self, other: object) -> bool:
        """Return whether the other one is a unit of the same id."""
        return isinstance(other, Unit) and self.id == other.id

    def __hash__(self) -> int:
        """Return the hash of the id."""
        return hash(self.id)


Load = Callable[[Unit], Any]
"""Reads the result of a unit that is done."""

Compute = Callable[[Sequence[Unit], Load], Iterator[Mapping[Unit, Any]]]
"""Computes units that belong together, and yields their results in batches as they come."""


@dataclass(frozen=True)
class Kind:
    """What the engine knows of a kind of unit.

    Attributes
    ----------
    result
        The frozen dataclass of arrays that is stored.
    scope
        What a unit depends on at most: the ground and track, the speed as well, or the whole case.
    needs
        The units whose results must be there before.
    together
        Units whose `compute` and `together` agree are computed by one task.
    compute
        Computes the units of one task.
    size
        Bytes of the arrays of a unit, as far as they are known before.
    memory
        Bytes that computing a unit needs beyond an idle worker.
    at_once
        How many units of a task need that at the same time, at most; all of them if it is None.
    label
        What tells a unit from others whose results may lie in one group with its own; None: it lies alone.
    """

    result: type
    scope: Callable[[Inputs], Scope]
    needs: Callable[[Inputs], Sequence[Unit]]
    together: Callable[[Inputs], Hashable]
    compute: Compute
    size: Callable[[Inputs], int]
    memory: Callable[[Inputs], int]
    at_once: int | None = None
    label: Callable[[Inputs], str | None] = lambda inputs: None


def registry(module: str) -> Mapping[str, Kind]:
    """Return the kinds that a module offers, by name."""
    kinds: Mapping[str, Kind] = importlib.import_module(module).KINDS
    return kinds
