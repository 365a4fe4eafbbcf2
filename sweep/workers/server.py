"""Imported by the process from which workers are forked: it ends with the driver, and they end with it."""

import os

from sweep.processes import parent
from sweep.processes.forks import DRIVER

parent.let_forks_end_with_this_process()
if DRIVER in os.environ:
    parent.end_with(int(os.environ[DRIVER]))

import sweep.workers.preloaded  # noqa: E402, F401

parent.outlive()  # the thread that has started it: a pipe tells it of the driver's end from now on
