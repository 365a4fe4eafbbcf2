"""The machine, as far as times measured on it can be compared."""

import contextlib
import os
import platform
from functools import cache
from pathlib import Path


@cache
def host_class() -> str:
    """Return the kind of processor and the number of processors, within which times are comparable."""
    model = platform.processor() or platform.machine()
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    return f"{model} x{os.cpu_count()}"
