"""Rational fits of one ground over one block of frequencies."""

from railvib import cost
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.ground import Ground
from railvib.soil.rational_fit import RationalFit, fit_flexibility


class GroundFits:
    """The fits of one ground over one block, made as they are asked for.

    A fit starts from a neighbour inside the block by a fixed rule, so its value does not depend on the order
    of asking: the first frequency starts cold, the others of level 0 from the one below, those of a finer
    level from the one below at the coarser level. A homogeneous half-space depends on ρ/ω only and needs one
    fit for the whole block.
    """

    def __init__(self, ground: Ground, block: int, tolerance: float) -> None:
        self.ground = ground
        self.block = block
        self.tolerance = tolerance
        self._made: dict[tuple[int, int], RationalFit] = {}

    def at(self, level: int, k: int) -> RationalFit:
        """Return the fit at frequency index k of a level."""
        while level > 0 and k % 2 == 0:
            level, k = level - 1, k // 2
        if (level, k) not in self._made:
            self._made[level, k] = self._make(level, k)
        return self._made[level, k]

    def _make(self, level: int, k: int) -> RationalFit:
        first = int(blocks.indices(self.block, 0)[0])
        f = float(blocks.frequency(level, k))
        if (level, k) != (0, first) and self.ground.homogeneous:
            return self.at(0, first).scaled(f / float(blocks.frequency(0, first)))
        start = None if (level, k) == (0, first) else self.at(level, k - 1).start
        with cost.stage("fit") as spent:
            fit = fit_flexibility(self.ground, f, self.tolerance, start)
            spent.kernel_calls += 1
            if start is not None and fit.error > 10.0 * self.tolerance:
                cold = fit_flexibility(self.ground, f, self.tolerance)
                spent.kernel_calls += 1
                fit = min(fit, cold, key=lambda each: each.error)
        return fit
