"""Imported by the process from which workers are forked, see `sweep.prefork`: what every worker needs."""

import importlib
import os
from contextlib import suppress

import distributed.nanny
import distributed.worker

import sweep.task
from sweep.prefork import KINDS

__all__ = ["distributed", "sweep"]

with suppress(Exception):  # whatever is wrong will be wrong in the first task as well, and be told there
    importlib.import_module(os.environ[KINDS]).warm_up()
