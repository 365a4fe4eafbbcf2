"""Numba's cache: one process of a machine fills it at a time, and ends afterwards.

Two processes that write it at once can crash. A process that has compiled all kernels keeps hundreds of
megabytes that a process that loads them never needs.
"""

import fcntl
import importlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from importlib import metadata, resources
from pathlib import Path

from railvib.stages.stage import Stage
from sweep import identity
from sweep.host import host_class
from sweep.processes import forks, parent

_COMPILERS = ("numba", "llvmlite")


def kernels_folder() -> Path:
    """Return the folder of compiled kernels; create it if missing.

    Raises
    ------
    OSError
        If kernels cannot be kept.
    """
    from railvib.soil._kernels.layers import surface_flexibility

    path = surface_flexibility.stats.cache_path
    if path is None:
        raise FileNotFoundError("compiled kernels cannot be cached")
    folder = Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def load(stages: str) -> None:
    """Load the kernels of a module's stages; a forked process first compiles those not in the cache.

    Call it while no other thread runs. Where forking fails or is not available, kernels are compiled in this
    process.
    """
    module = importlib.import_module(stages)
    with suppress(OSError):  # an unwritable cache counts as absent
        marker = kernels_folder() / f"{_state(stages)}.compiled"
        if forks.POSSIBLE and not marker.exists():
            with alone():
                if not marker.exists() and _succeeds_apart(module.warm_up):
                    marker.touch()
    module.warm_up()


@cache
def compile_stage(stage: type[Stage]) -> None:
    """Compile the kernels that a stage needs beyond those that all processes load, once per process."""
    if stage.compile.__func__ is not Stage.compile.__func__:  # type: ignore[attr-defined]
        with alone():
            stage.compile()


def _succeeds_apart(warm_up: Callable[[], None]) -> bool:
    """Return whether a function succeeds in a forked process; its errors stay there."""
    this_process = os.getpid()
    process = os.fork()
    if process == 0:
        status = 1
        try:
            parent.end_with(this_process)
            warm_up()
            status = 0
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 0


def _state(stages: str) -> str:
    """Return the digest of everything that makes Numba compile again."""
    files = sorted(Path(str(resources.files("railvib"))).rglob("*.py"))
    return identity.digest(
        {
            "stages": stages,
            "python": sys.version,
            "host_class": host_class(),
            "compilers": list(map(metadata.version, _COMPILERS)),
            "sources": [f"{file} {file.stat().st_size} {file.stat().st_mtime_ns}" for file in files],
        }
    )


@contextmanager
def alone() -> Iterator[None]:
    """Compile into the cache as the only process: wait for others, and keep others waiting."""
    with ExitStack() as stack:
        with suppress(OSError):  # an unwritable cache counts as absent
            descriptor = os.open(kernels_folder(), os.O_RDONLY)
            stack.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
