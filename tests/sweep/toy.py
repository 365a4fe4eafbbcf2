"""Stages for tests of the engine: arithmetic on small arrays; a stage may raise or kill."""

import os
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from railvib import cost
from railvib.stages import Load, Scope, Stage
from sweep.unit import Unit, unit_of


@dataclass(frozen=True)
class Numbers:
    """A row of numbers."""

    value: np.ndarray = field(metadata={"dims": ("index",), "unit": "m"})
    label: str
    pair: tuple[int, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Arithmetic(Stage):
    """What the stages have in common."""

    marks: str | None = None
    sleep: float = 0.0

    @classmethod
    def result_type(cls) -> type[Numbers]:
        """Return the numbers."""
        return Numbers

    def _leave_mark(self, name: str) -> None:
        """Leave a file per start, so that a test can count starts across processes."""
        if self.marks is not None:
            (Path(self.marks) / f"{name}-{os.getpid()}-{time.monotonic_ns()}").touch()

    def nbytes(self) -> int:
        """Return the bytes of three numbers."""
        return 24

    def memory(self) -> int:
        """Return the same."""
        return 24


@dataclass(frozen=True, eq=False, kw_only=True)
class Square(Arithmetic):
    """The squares around a number."""

    number: float
    poison: str | None = None
    name: ClassVar[str] = "square"
    scope: ClassVar[Scope] = "ground"

    def together(self) -> float:
        """Return the same for an even number and the next."""
        return self.number // 2

    def compute(self, load: Load) -> Numbers:
        """Square, raise or kill."""
        self._leave_mark(f"{self.number}")
        if self.poison == "raise":
            raise ValueError(f"cannot square {self.number}")
        if self.poison == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.sleep)
        with cost.stage("square") as spent:
            spent.evaluations += 3
            value = (self.number + np.arange(3.0)) ** 2
        return Numbers(value, f"square of {self.number:g}", (1, 2))


@dataclass(frozen=True, eq=False, kw_only=True)
class Total(Arithmetic):
    """The sum of the squares of several numbers."""

    numbers: tuple[float, ...]
    poisons: tuple[tuple[str, str], ...] = ()
    name: ClassVar[str] = "total"
    scope: ClassVar[Scope] = "case"

    def needs(self) -> list[Square]:
        """Return the squares."""
        poisons = dict(self.poisons)
        return [
            Square(number=number, poison=poisons.get(str(number)), marks=self.marks, sleep=self.sleep)
            for number in self.numbers
        ]

    def compute(self, load: Load) -> Numbers:
        """Sum the squares."""
        self._leave_mark("total")
        return Numbers(np.sum([load(part).value for part in self.needs()], axis=0), "total", ())


def square(number: float, **more: Any) -> Unit:
    """Return the unit of the squares around a number."""
    return unit_of(Square(number=float(number), **more))


def total(*numbers: float, poisons: dict[str, str] | None = None, **more: Any) -> Unit:
    """Return the unit that sums the squares of several numbers."""
    pairs = tuple(sorted((poisons or {}).items()))
    return unit_of(Total(numbers=tuple(sorted(map(float, numbers))), poisons=pairs, **more))


def warm_up() -> None:
    """Nothing is compiled here."""


STAGES = {stage.__name__: stage for stage in (Square, Total)}
