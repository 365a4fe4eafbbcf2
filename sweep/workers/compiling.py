"""Numba's cache: one process of a machine fills it at a time, and not one that computes afterwards.

Two that write it at once can crash, and a process that has compiled all kernels keeps some hundreds of
megabytes that one that loads them never takes.
"""

import importlib
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import metadata, resources
from pathlib import Path

from railvib.soil.flexibility import surface_flexibility
from railvib.stages.stage import Stage
from sweep import identity
from sweep.host import host_class
from sweep.workers import forks

LOCK = "compiling.lock"
_COMPILERS = ("numba", "llvmlite")


def cache_folder() -> Path:
    """Return where a user's programs keep what they can make again."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "railvib"


def load(kinds: str) -> None:
    """Load the kernels of a module's kinds; a process forked for it compiles what may not be compiled yet.

    To be called where no other thread runs. Where the forked process fails, and where forking is not to be
    had, kernels are compiled here.
    """
    module = importlib.import_module(kinds)
    done = Path(str(surface_flexibility.stats.cache_path)) / f"{_state(kinds)}.compiled"
    if forks.POSSIBLE and not done.exists():
        with alone(), suppress(OSError):  # a cache that cannot be written is none
            if not done.exists() and _succeeds_apart(module.warm_up):
                done.parent.mkdir(parents=True, exist_ok=True)
                done.touch()
    module.warm_up()


@cache
def compile_stage(stage: type[Stage]) -> None:
    """Compile the kernels that a stage needs beyond those that all processes load, once per process."""
    if stage.compile.__func__ is not Stage.compile.__func__:  # type: ignore[attr-defined]
        with alone():
            stage.compile()


def _succeeds_apart(warm_up: Callable[[], None]) -> bool:
    """Return whether a function returns in a forked process, which keeps to itself why it does not."""

    def call() -> None:
        try:
            warm_up()
        except Exception:
            sys.exit(1)

    process = multiprocessing.get_context("fork").Process(target=call)
    process.start()
    process.join()
    return process.exitcode == 0


def _state(kinds: str) -> str:
    """Return the digest of all that makes Numba compile anew."""
    files = sorted(Path(str(resources.files("railvib"))).rglob("*.py"))
    return identity.digest(
        {
            "kinds": kinds,
            "python": sys.version,
            "host_class": host_class(),
            "compilers": list(map(metadata.version, _COMPILERS)),
            "sources": [f"{file} {file.stat().st_size} {file.stat().st_mtime_ns}" for file in files],
        }
    )


@contextmanager
def alone() -> Iterator[None]:
    """Wait until no other process of this user compiles inside such a block, and keep others waiting."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
