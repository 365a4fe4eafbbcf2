"""The product's kinds of work, of which some spectra raise or kill, as an environment variable says."""

import json
import os
import signal
from dataclasses import replace

from sweep.units import (
    KINDS as SOUND,
)
from sweep.units import (
    KMH,
    check_plausibility,
    spectra_unit,
    unevenness_bands,
)

__all__ = ["KINDS", "check_plausibility", "spectra_unit", "unevenness_bands"]

POISON = "RAILVIB_TEST_POISON"
"""JSON: what to do at which speed in km/h."""


def _spectra(units, load):
    for unit in units:
        poison = json.loads(os.environ.get(POISON, "{}")).get(f"{unit.inputs['speed'] * KMH:g}")
        if poison == "raise":
            raise ArithmeticError(f"poisoned at {unit.inputs['speed'] * KMH:g} km/h")
        if poison == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        yield from SOUND["spectra"].compute([unit], load)


KINDS = {**SOUND, "spectra": replace(SOUND["spectra"], compute=_spectra)}


def warm_up():
    """Do without: the kernels have been compiled, and a worker that is soon killed loads few of them."""
