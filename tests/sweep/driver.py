"""The program as a process of its own, for tests that kill it, and what is left of its processes."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import psutil

ROOT = Path(__file__).parents[2]
PROGRAM = "from railvib.cli import main; main()"


def start(folder, *arguments, before=""):
    """Start the program in a session of its own, after some Python has run in its process."""
    return subprocess.Popen(
        [sys.executable, "-c", f"{before}\n{PROGRAM}", *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def ended(process):
    """Wait for the program's end; return its exit code and what it said."""
    _, errors = process.communicate(timeout=120)
    return process.returncode, errors


def alive(group):
    """Return the processes of a group that are more than an entry in the system's table."""
    living = []
    for process in psutil.process_iter():
        with contextlib.suppress(ProcessLookupError, psutil.Error):
            if os.getpgid(process.pid) == group and process.status() != psutil.STATUS_ZOMBIE:
                living.append(process.cmdline())
    return living


def left_behind(group):
    """Return the processes of a group that are still there after some seconds."""
    deadline = time.monotonic() + 20.0
    while alive(group) and time.monotonic() < deadline:
        time.sleep(0.1)
    return alive(group)
