"""Processes that draw figures while other work goes on."""

import gc
import importlib
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import lru_cache
from multiprocessing import get_all_start_methods, get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import NamedTuple

import duckdb

from queries.database import ResultsError, connect, reason
from queries.figures import catalogue
from queries.figures.drawing import Drawing
from queries.figures.write import write

WORKERS = min(os.cpu_count() or 1, 4)
"""Processes that draw."""
_PLOTS = "queries.figures.level_plots"
"""Module that brings the plotting library."""


class _Request(NamedTuple):
    """The figures of a snapshot, into a folder, in a format: the paper's, or `every` one."""

    path: Path
    written_ns: int
    folder: Path
    kind: str
    every: bool


class FigureProcesses:
    """Processes that draw; they load the plotting library as soon as they are made.

    Parameters
    ----------
    workers
        How many; 0 draws in this process.
    """

    def __init__(self, workers: int) -> None:
        self._pool: ProcessPoolExecutor | None = None
        if workers:
            forking = "forkserver" in get_all_start_methods()
            context = get_context("forkserver" if forking else "spawn")
            context.set_forkserver_preload([_PLOTS])  # unless the engine has started its server already
            self._pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_prepare)
            with _block_interrupts():  # the server inherits it
                for _ in range(workers):
                    self._pool.submit(_load)

    def __enter__(self) -> "FigureProcesses":
        """Return itself; leaving the block waits for the processes to end."""
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def start(
        self,
        connection: duckdb.DuckDBPyConnection,
        path: Path,
        folder: Path,
        kind: str = "png",
        every: bool = False,
    ) -> Callable[[], list[Path]]:
        """Begin to draw the figures of a database into a folder.

        Parameters
        ----------
        connection, path
            The database, and its file.
        folder
            Made if missing.
        kind
            png, svg or pdf.
        every
            Not those of the paper alone.

        Returns
        -------
        Waits until all are drawn and returns their files; those of an earlier state are gone then.

        Raises
        ------
        ResultsError
            If the folder cannot be written.
        """
        drawings = catalogue.drawings(connection, every)
        request = _Request(path, path.stat().st_mtime_ns, folder, kind, every)
        waiting: list[Future[None]] = []
        with _faults_in(folder):
            folder.mkdir(parents=True, exist_ok=True)
            if self._pool is not None:
                # The last figures have the most panels: first, lest one process end long after the others.
                waiting = [self._pool.submit(_draw, request, drawing.name) for drawing in reversed(drawings)]

        def finish() -> list[Path]:
            with _faults_in(folder):
                if self._pool is None:
                    for drawing in drawings:
                        write(drawing, folder, kind)
                for future in waiting:
                    future.result()
                return catalogue.clear(folder, kind, drawings)

        return finish


@contextmanager
def _faults_in(folder: Path) -> Iterator[None]:
    """Turn a folder that cannot be written, and a process that is lost, into errors of one line."""
    try:
        yield
    except OSError as error:
        raise ResultsError(f"{folder}: cannot be written: {reason(error)}") from error
    except BrokenProcessPool as error:
        raise ResultsError("a process that draws figures exited unexpectedly") from error


@contextmanager
def _block_interrupts() -> Iterator[None]:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _prepare() -> None:
    """Leave Ctrl-C to the parent, end with it, and keep what is loaded out of garbage collection."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.freeze()  # looking there would copy memory that processes share
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    Thread(target=watch, daemon=True).start()


def _load() -> None:
    """Load the plotting library, where the server has not done so."""
    importlib.import_module(_PLOTS)


def _draw(request: _Request, name: str) -> None:
    """Draw one figure of a request."""
    write(_drawings(request)[name], request.folder, request.kind)


@lru_cache(1)
def _drawings(request: _Request) -> dict[str, Drawing]:
    """Return the figures of a request by name, on a connection that stays open for them."""
    connection = connect(request.path, bounded=True)
    return {drawing.name: drawing for drawing in catalogue.drawings(connection, request.every)}
