"""A stage of next to no work, for benchmarks of the engine alone."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from railvib.stages import Load, Scope, Stage


@dataclass(frozen=True)
class Numbers:
    """A row of numbers."""

    value: np.ndarray = field(metadata={"dims": ("index",), "unit": "1"})


@dataclass(frozen=True, eq=False, kw_only=True)
class Square(Stage):
    """The squares of three numbers."""

    number: float
    name: ClassVar[str] = "square"
    scope: ClassVar[Scope] = "ground"

    @classmethod
    def result_type(cls) -> type[Numbers]:
        """Return the numbers."""
        return Numbers

    def compute(self, load: Load) -> Numbers:
        """Square them."""
        return Numbers((self.number + np.arange(3.0)) ** 2)

    def nbytes(self) -> int:
        """Return the bytes of three numbers."""
        return 24

    def memory(self) -> int:
        """Return the bytes of three numbers."""
        return 24


def warm_up() -> None:
    """Compile nothing."""


STAGES = {Square.__name__: Square}
