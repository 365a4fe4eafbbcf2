"""The product's stages, of which some spectra raise or kill, as an environment variable says."""

import json
import os
import signal

from railvib import stages
from railvib.parameters.units import KMH
from railvib.stages.moving_roughness import MovingRoughnessSpectra

POISON = "RAILVIB_TEST_POISON"
"""JSON: what to do at which speed in km/h."""


class Poisoned(MovingRoughnessSpectra):
    """Spectra that raise or kill at some speeds."""

    @classmethod
    def compute_together(cls, stages, load):
        """Compute, raise or kill."""
        for stage in stages:
            poison = json.loads(os.environ.get(POISON, "{}")).get(f"{stage.speed * KMH:g}")
            if poison == "raise":
                raise ArithmeticError(f"poisoned at {stage.speed * KMH:g} km/h")
            if poison == "kill":
                os.kill(os.getpid(), signal.SIGKILL)
            yield {stage: stage.compute(load)}


STAGES = {**stages.STAGES, MovingRoughnessSpectra.__name__: Poisoned}


def warm_up():
    """Do without: the kernels have been compiled, and a worker that is soon killed loads few of them."""
