"""Section 1: values of Q33 per second and core, against matrices in NumPy and the limit of the core."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.figures import Figure, time_call
from benchmarks.limit.operations import count_operations
from benchmarks.limit.rates import Rates
from benchmarks.peers import stiffness_matrices
from benchmarks.runs import soils
from benchmarks.sizes import Size
from railvib.numerics import threads
from railvib.numerics.vector_math import LANES
from railvib.soil._kernels.layers import surface_flexibilities

SECTION = "kernel"
LAYERS = (1, 3, 10)
FREQUENCY = 20.0
FACTOR_OF_LIMIT = 4.0
_PEERS = {
    "Q33, NumPy, np.linalg.solve": stiffness_matrices.by_linear_algebra,
    "Q33, NumPy, 2 × 2 elimination": stiffness_matrices.by_elimination,
}


def measure(size: Size, rates: Rates) -> Iterator[Figure]:
    """Yield rates and ratios for grounds with several numbers of layers."""
    omega = 2.0 * np.pi * FREQUENCY
    r = np.geomspace(1e-2, 20.0, size.wavenumbers)
    for layers in LAYERS:
        ground = soils.ground(layers)
        stack, rigid = ground.stack(), ground.base == "rigid"
        case = f"{layers} layer{'s' if layers > 1 else ''}"

        timing = time_call(partial(surface_flexibilities, r, omega, stack, rigid), size.samples)
        rate = tuple(r.size / seconds for seconds in timing.cpu_s)
        yield Figure(SECTION, "Q33, railvib", case, "rate", "1/s", rate)
        per_value = timing.cpu / r.size
        for name, flexibility in _PEERS.items():
            part = r[:: max(1, r.size // 4096)]
            with threads.single():
                peer = time_call(partial(flexibility, ground, part, omega), size.samples)
            rate = tuple(part.size / seconds for seconds in peer.cpu_s)
            yield Figure(SECTION, name, case, "rate", "1/s", rate)
            speedup = peer.cpu / part.size / per_value
            yield Figure(SECTION, name, case, "railvib is faster by", "1", (speedup,))
        _, count = count_operations(surface_flexibilities, (r[:LANES], omega, stack, rigid), plain=(3,))
        value = count.per(LANES)
        yield Figure(SECTION, "Q33, operations of a value", case, "count", "1", (value.total,))
        item = "Q33, time over limit"
        ratio = per_value / value.seconds(rates)
        quantity = "all at the multiply-add rate"
        yield Figure(SECTION, item, case, quantity, "1", (ratio,), at_most=FACTOR_OF_LIMIT)
        ratio = per_value / value.seconds_by_kind(rates)
        yield Figure(SECTION, item, case, "divisions and roots at their rates", "1", (ratio,))
