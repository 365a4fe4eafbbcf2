"""The class of a machine, within which measured times are comparable."""

import contextlib
import os
import platform
from functools import cache
from pathlib import Path


@cache
def host_class() -> str:
    """Return the kind of processor and the number of processors, within which times are comparable."""
    return f"{_model()} x{os.cpu_count()}"


def _model() -> str:
    """Return the kind of processor, as Linux tells it, or else the library, which starts a process to ask."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
