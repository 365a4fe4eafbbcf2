"""Section 1: values of Q33 per second and core, against matrices in NumPy and the limit of the core."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks import soils, stiffness_matrices
from benchmarks.arithmetic import Rates
from benchmarks.figures import Figure, timed
from benchmarks.operations import counted
from benchmarks.sizes import Size
from railvib.numerics import threads
from railvib.numerics.vector_math import LANES
from railvib.soil.flexibility import surface_flexibilities

SECTION = "kernel"
LAYERS = (1, 3, 10)
FREQUENCY = 20.0
FACTOR_OF_LIMIT = 4.0


def measure(size: Size, rates: Rates) -> Iterator[Figure]:
    """Yield rates and ratios for grounds of several numbers of layers."""
    omega = 2.0 * np.pi * FREQUENCY
    r = np.geomspace(1e-2, 20.0, size.wavenumbers)
    for layers in LAYERS:
        ground = soils.ground(layers)
        stack, rigid = ground.stack(), ground.base == "rigid"
        case = f"{layers} layer{'s' if layers > 1 else ''}"

        ours = timed(partial(surface_flexibilities, r, omega, stack, rigid), size.samples)
        rate = tuple(r.size / each for each in ours.cpu_s)
        yield Figure(SECTION, "Q33, railvib", case, "rate", "1/s", rate)
        for name, way in (
            ("Q33, NumPy, np.linalg.solve", stiffness_matrices.by_linear_algebra),
            ("Q33, NumPy, 2 × 2 elimination", stiffness_matrices.by_elimination),
        ):
            part = r[:: max(1, r.size // 4096)]
            with threads.single():
                peer = timed(partial(way, ground, part, omega), size.samples)
            rate = tuple(part.size / each for each in peer.cpu_s)
            yield Figure(SECTION, name, case, "rate", "1/s", rate)
            speedup = peer.cpu / part.size / (ours.cpu / r.size)
            yield Figure(SECTION, name, case, "railvib is faster by", "1", (speedup,))
        _, count = counted(surface_flexibilities, (r[:LANES], omega, stack, rigid), plain=(3,))
        each = count.per(LANES)
        yield Figure(SECTION, "Q33, operations of a value", case, "count", "1", (each.total,))
        per_value = ours.cpu / r.size
        yield Figure(
            SECTION,
            "Q33, time over limit",
            case,
            "all at the multiply-add rate",
            "1",
            (per_value / each.seconds(rates),),
            at_most=FACTOR_OF_LIMIT,
        )
        yield Figure(
            SECTION,
            "Q33, time over limit",
            case,
            "divisions and roots at their rates",
            "1",
            (per_value / each.seconds_by_kind(rates),),
        )
