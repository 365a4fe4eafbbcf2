"""What one (β, ω) of the FE/BE model costs, and where the time goes: CPU microseconds per value, by stage.

.venv/bin/python -m benchmarks.fe_be
"""

import numpy as np

from railvib import cost, library
from railvib.fe_be.model import FeBeModel, fe_be_response
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.cross_section import CrossSection
from railvib.soil.fits import GroundFits

BLOCK = 2
OFFSETS = (8.0, 32.0)


def main() -> None:
    """Print a line per soil for a block of frequencies, and one for a single value with nothing reused."""
    track = library.load("track", "ballasted-paper")
    section = CrossSection()
    for soil in ("horstwalde", "greby"):
        ground = library.load("soil", soil)
        fe_be_response(ground, track, section, 20.0, [0.1], OFFSETS)  # compiles the kernels
        ks = blocks.indices(BLOCK, 0)
        beta = np.linspace(0.0, 20.0, 300)
        with cost.collect() as costs:
            model = FeBeModel(ground, track, section, BLOCK)
            evaluate = model(GroundFits(ground, BLOCK, 1e-9), track, OFFSETS, 1e-3)
            for k in ks:
                evaluate(0, int(k), beta)
        values = ks.size * beta.size
        stages = ", ".join(f"{stage.stage} {1e6 * stage.cpu_s / values:.0f}" for stage in costs)
        total = sum(stage.cpu_s for stage in costs)
        print(f"{soil}: {1e6 * total / values:.0f} µs per (β, ω) over {values} values: {stages}")
        with cost.collect() as costs:
            fe_be_response(ground, track, section, 20.0, [0.1], OFFSETS)
        stages = ", ".join(f"{stage.stage} {1e3 * stage.cpu_s:.1f}" for stage in costs)
        print(f"{soil}: one (β, ω) with nothing reused, ms: {stages}")


if __name__ == "__main__":
    main()
