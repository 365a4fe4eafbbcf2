"""The product's kinds of work, of which some spectra raise or kill, as an environment variable says."""

import json
import os
import signal
from dataclasses import replace
from typing import Any

from railvib.parameters.units import KMH
from sweep import units as sound

POISON = "RAILVIB_TEST_POISON"
"""JSON: what to do at which speed in km/h."""


def __getattr__(name: str) -> Any:
    """Return what is not poisoned."""
    return getattr(sound, name)


def _spectra(units, load):
    for unit in units:
        poison = json.loads(os.environ.get(POISON, "{}")).get(f"{unit.inputs['speed'] * KMH:g}")
        if poison == "raise":
            raise ArithmeticError(f"poisoned at {unit.inputs['speed'] * KMH:g} km/h")
        if poison == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        yield from sound.KINDS["spectra"].compute([unit], load)


KINDS = {**sound.KINDS, "spectra": replace(sound.KINDS["spectra"], compute=_spectra)}


def warm_up():
    """Do without: the kernels have been compiled, and a worker that is soon killed loads few of them."""
