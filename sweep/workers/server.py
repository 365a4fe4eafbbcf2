"""Preload of the server process from which workers are forked; it ends with the driver, they with it."""

import os

from sweep.processes import parent
from sweep.processes.forks import DRIVER

parent.let_forks_end_with_this_process()
if DRIVER in os.environ:
    parent.end_with(int(os.environ[DRIVER]))

import sweep.workers.preloaded  # noqa: E402, F401

parent.outlive()  # the thread that started it; from now on a pipe reports the driver's end
