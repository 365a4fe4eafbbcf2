"""The rational fits of one ground over one block of frequencies."""

from collections.abc import Callable
from typing import Generic, Protocol, Self, TypeVar

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.ground import Ground
from railvib.soil.barycentric import Start
from railvib.soil.rational_fit import RationalFit, fit_flexibility


class _Fit(Protocol):
    """What fits of Q33 and of the tensor have in common."""

    @property
    def error(self) -> float: ...

    @property
    def start(self) -> Start: ...

    def scale(self, ratio: float) -> Self: ...


Fit = TypeVar("Fit", bound=_Fit)


class BlockFits(Generic[Fit]):
    """The fits of one ground over one block, each made when it is first asked for.

    A fit starts from a neighbour inside the block by a fixed rule, so its value does not depend on the order
    of asking: the first frequency starts cold, the others of level 0 from the one below, those of a finer
    level from the one below at the coarser level. A homogeneous half-space depends on ρ/ω only and needs one
    fit for the whole block.

    Parameters
    ----------
    ground, block
        The ground, and the index of the block, see `railvib.numerics.frequency_blocks`.
    fit
        Returns the fit at a frequency in Hz, from a neighbour's start or cold.
    """

    def __init__(self, ground: Ground, block: int, fit: Callable[[float, Start | None], Fit]) -> None:
        self.ground = ground
        self.block = block
        self._fit = fit
        self._fits: dict[tuple[int, int], Fit] = {}

    def at(self, level: int, k: int) -> Fit:
        """Return the fit at frequency index k of a level."""
        while level > 0 and k % 2 == 0:
            level, k = level - 1, k // 2
        if (level, k) not in self._fits:
            self._fits[level, k] = self._new(level, k)
        return self._fits[level, k]

    def _new(self, level: int, k: int) -> Fit:
        first = int(blocks.indices(self.block, 0)[0])
        frequency = float(blocks.frequency(level, k))
        if (level, k) == (0, first):
            return self._fit(frequency, None)
        if self.ground.homogeneous:
            return self.at(0, first).scale(frequency / float(blocks.frequency(0, first)))
        return self._fit(frequency, self.at(level, k - 1).start)


class GroundFits(BlockFits[RationalFit]):
    """The fits of Q33 of one ground over one block to a tolerance, up to a wavenumber or further."""

    def __init__(self, ground: Ground, block: int, tolerance: float, largest: float = 0.0) -> None:
        def fit(frequency: float, start: Start | None) -> RationalFit:
            return warm_or_cold(
                "fit",
                lambda start: fit_flexibility(ground, frequency, tolerance, start, largest),
                start,
                10.0 * tolerance,
            )

        super().__init__(ground, block, fit)


def warm_or_cold(stage: str, fit: Callable[[Start | None], Fit], start: Start | None, limit: float) -> Fit:
    """Return a fit from a neighbour's start; where its error is above a limit, a cold one if that is better.

    Parameters
    ----------
    stage
        Stage of `railvib.cost` that takes the time.
    fit
        Fits from a start, or cold.
    start
        The neighbour's, if there is one.
    limit
        Error that is not to be exceeded.
    """
    with cost.stage(stage) as spent:
        warm = fit(start)
        spent.kernel_calls += 1
        if start is None or warm.error <= limit:
            return warm
        spent.kernel_calls += 1
        return min(warm, fit(None), key=lambda candidate: candidate.error)
