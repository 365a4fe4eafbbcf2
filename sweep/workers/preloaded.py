"""What every worker needs, loaded by the process from which they are forked."""

import gc
import os
from contextlib import suppress

gc.disable()  # imports stay alive: collecting garbage among them would take a sixth of the time

import distributed.nanny  # noqa: E402
import distributed.worker  # noqa: E402

import sweep.running.task  # noqa: E402
from sweep.processes import compiling  # noqa: E402
from sweep.processes.forks import STAGES_MODULE  # noqa: E402

__all__ = ["distributed", "sweep"]

with suppress(Exception):  # an error will occur in the first task again, and be reported there
    compiling.load(os.environ[STAGES_MODULE])

gc.freeze()  # nor in workers, where it would copy shared memory
gc.enable()
