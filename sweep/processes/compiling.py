"""Numba's cache: one process of a machine fills it at a time, and not one that computes afterwards.

Two that write it at once can crash, and a process that has compiled all kernels keeps some hundreds of
megabytes that one that loads them never takes.
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

from railvib.soil._kernels.layers import surface_flexibility
from railvib.stages.stage import Stage
from sweep import identity
from sweep.host import host_class
from sweep.processes import forks, parent

_COMPILERS = ("numba", "llvmlite")


def kernels_folder() -> Path:
    """Return where compiled kernels are kept, made if missing.

    Raises
    ------
    OSError
        If they cannot be kept.
    """
    path = surface_flexibility.stats.cache_path
    if path is None:
        raise FileNotFoundError("compiled kernels are not kept")
    folder = Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def load(stages: str) -> None:
    """Load the kernels of a module's stages; a process forked for it compiles what may not be compiled yet.

    To be called where no other thread runs. Where the forked process fails, and where forking is not to be
    had, kernels are compiled here.
    """
    module = importlib.import_module(stages)
    with suppress(OSError):  # a cache that cannot be written is none
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
    """Return whether a function returns in a forked process, which keeps to itself why it does not."""
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
    """Return the digest of all that makes Numba compile anew."""
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
    """Wait until no other process compiles into the cache inside such a block, and keep others waiting."""
    with ExitStack() as stack:
        with suppress(OSError):  # a cache that cannot be written is none
            descriptor = os.open(kernels_folder(), os.O_RDONLY)
            stack.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
