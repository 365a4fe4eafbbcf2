"""Stage: the transfer function of one receiver over one block by finite and boundary elements."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, ClassVar, Self

import numpy as np

from railvib import library
from railvib.parameters.cross_section import CrossSection
from railvib.stages.stage import Work
from railvib.stages.transfer_table import TransferTable, likely_size
from railvib.transfer.receiver_classes import distance_class

_BYTES = 128 * 2**20
"""The bed, and the matrices of many wavenumbers; 75 MB were measured with eight strips and three rows."""
_CHECKS = 5
_PANEL_ROWS = 9
"""Rows of nodes that finding the panels takes, about: three frequencies, halved some times."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FeBeTable(TransferTable):
    """Table of a receiver's transfer function by the FE/BE model."""

    cross_section: CrossSection = field()  # not optional here
    SORT: ClassVar[str] = "fe-be transfer"

    @classmethod
    def compile(cls) -> None:
        """Compile the kernels of the FE/BE model."""
        _compile()

    def evaluation(self) -> Any:
        """Return the FE/BE model of the block."""
        from railvib.fe_be.model import FeBeModel

        return FeBeModel(self.ground, self.track, self.cross_section, self.block, self.refinement)

    def memory(self) -> int:
        """Estimate what tabulating takes."""
        return super().memory() + _BYTES

    @classmethod
    def work_together(cls, stages: Sequence[Self]) -> Work:
        """Return the places at which the model is evaluated, shared by the receivers of a class."""
        places: dict[float, float] = {}
        for stage in stages:
            rows, nodes = likely_size(stage.ground, stage.block, stage.receiver)
            reach = distance_class(stage.receiver)
            places[reach] = max(places.get(reach, 0.0), (rows + _CHECKS + _PANEL_ROWS) * nodes)
        return Work(cls.SORT, {"values": sum(places.values())})


@cache
def _compile() -> None:
    from railvib.fe_be.boundary_elements import receiver_flexibility, strip_flexibility
    from railvib.soil.tensor_fit import fit_tensor

    strip = np.array([0.0, 1.0])
    fit = fit_tensor(library.load("soil", "horstwalde"), 1.0, 1e-2)
    strip_flexibility(fit, strip, strip)
    receiver_flexibility(fit, strip, strip, strip)
