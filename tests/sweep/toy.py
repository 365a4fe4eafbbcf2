"""Kinds of work for tests of the engine: arithmetic on small arrays; a unit may raise or kill."""

import os
import signal
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from railvib import cost
from sweep.kinds import Inputs, Kind, Load, Unit


@dataclass(frozen=True)
class Numbers:
    """A row of numbers."""

    value: np.ndarray = field(metadata={"dims": ("index",), "unit": "m"})
    label: str
    pair: tuple[int, ...]


def square(number: float, **more: Any) -> Unit:
    """Return the unit of the squares around a number."""
    return Unit.of("square", number=number, **more)


def total(*numbers: float, **more: Any) -> Unit:
    """Return the unit that sums the squares of several numbers."""
    return Unit.of("total", numbers=sorted(numbers), **more)


def _squares(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, Numbers]]:
    for unit in units:
        number = unit.inputs["number"]
        _leave_mark(unit.inputs)
        if unit.inputs.get("poison") == "raise":
            raise ValueError(f"cannot square {number}")
        if unit.inputs.get("poison") == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(unit.inputs.get("sleep", 0.0))
        with cost.stage("square") as spent:
            spent.evaluations += 3
            value = (number + np.arange(3.0)) ** 2
        yield {unit: Numbers(value, f"square of {number:g}", (1, 2))}


def _totals(units: Sequence[Unit], load: Load) -> Iterator[Mapping[Unit, Numbers]]:
    for unit in units:
        _leave_mark(unit.inputs)
        parts = [load(part).value for part in _parts(unit.inputs)]
        yield {unit: Numbers(np.sum(parts, axis=0), "total", ())}


def _leave_mark(inputs: Inputs) -> None:
    """Leave a file per start, so that a test can count starts across processes."""
    if "marks" in inputs:
        folder = Path(inputs["marks"])
        (folder / f"{inputs.get('number', 'total')}-{os.getpid()}-{time.monotonic_ns()}").touch()


def _parts(inputs: Inputs) -> list[Unit]:
    more = {key: inputs[key] for key in ("marks", "sleep") if key in inputs}
    poison = inputs.get("poisons", {})
    return [
        square(number, **more, **({"poison": poison[str(number)]} if str(number) in poison else {}))
        for number in inputs["numbers"]
    ]


def warm_up() -> None:
    """Nothing is compiled here."""


KINDS = {
    "square": Kind(
        result=Numbers,
        scope=lambda inputs: "ground",
        needs=lambda inputs: [],
        together=lambda inputs: inputs["number"] // 2,
        compute=_squares,
        size=lambda inputs: 24,
        memory=lambda inputs: 24,
    ),
    "total": Kind(
        result=Numbers,
        scope=lambda inputs: "case",
        needs=_parts,
        together=lambda inputs: tuple(inputs["numbers"]),
        compute=_totals,
        size=lambda inputs: 24,
        memory=lambda inputs: 24,
    ),
}
