"""What every worker needs, loaded by the process from which they are forked."""

import gc
import os
from contextlib import suppress

gc.disable()  # all that is imported stays: looking for garbage in it would take a sixth of the time

import distributed.nanny  # noqa: E402
import distributed.worker  # noqa: E402

import sweep.running.task  # noqa: E402
from sweep.processes import compiling  # noqa: E402
from sweep.processes.forks import STAGES_MODULE  # noqa: E402

__all__ = ["distributed", "sweep"]

with suppress(Exception):  # whatever is wrong will be wrong in the first task as well, and be told there
    compiling.load(os.environ[STAGES_MODULE])

gc.freeze()  # nor do workers look there, who would copy the memory that they share by doing so
gc.enable()
