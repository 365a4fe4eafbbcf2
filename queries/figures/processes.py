"""Processes that draw figures in the background.

What drawing takes is imported where it is used, so that the driver of a run starts the processes without
delay: they load it while the last tasks run.
"""

import gc
import importlib
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import lru_cache
from multiprocessing import get_all_start_methods, get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import duckdb

    from queries.figures.drawing import Drawing

WORKERS = min(os.cpu_count() or 1, 4)
"""Number of processes that draw."""
_PLOTS = "queries.figures.level_plots"
"""Module that loads the plotting library."""


class _Request(NamedTuple):
    """The figures of a snapshot, into a folder, in a format: the paper's, or `every` one."""

    path: Path
    written_ns: int
    folder: Path
    kind: str
    every: bool


class FigureProcesses:
    """Processes that draw, forked from one that loads the plotting library as soon as they are made.

    Parameters
    ----------
    workers
        How many draw; 0 draws in this process.
    """

    def __init__(self, workers: int) -> None:
        self._pool: ProcessPoolExecutor | None = None
        if workers:
            forking = "forkserver" in get_all_start_methods()
            context = get_context("forkserver" if forking else "spawn")
            self._pool = ProcessPoolExecutor(
                1, mp_context=context, initializer=_prepare_loader, initargs=(workers,)
            )
            with _block_interrupts():  # the server inherits it
                self._pool.submit(int)

    def __enter__(self) -> "FigureProcesses":
        """Return itself; leaving the block waits until the processes end."""
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            with suppress(BrokenProcessPool):
                self._pool.submit(_end_drawers)
            self._pool.shutdown()

    def start(
        self,
        connection: "duckdb.DuckDBPyConnection",
        path: Path,
        folder: Path,
        kind: str = "png",
        every: bool = False,
    ) -> Callable[[], list[Path]]:
        """Start drawing the figures of a database into a folder.

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
        Waits until all are drawn and outdated ones removed, and returns their files.

        Raises
        ------
        ResultsError
            If the folder cannot be written.
        """
        from queries.figures import catalogue
        from queries.figures.write import write

        drawings = catalogue.drawings(connection, every)
        request = _Request(path, path.stat().st_mtime_ns, folder, kind, every)
        drawn: Future[None] | None = None
        with _faults_in(folder):
            folder.mkdir(parents=True, exist_ok=True)
            if self._pool is not None:
                # The last figures have the most panels: draw them first, so that no process ends late.
                names = [drawing.name for drawing in reversed(drawings)]
                drawn = self._pool.submit(_draw_all, request, names)

        def finish() -> list[Path]:
            with _faults_in(folder):
                if drawn is not None:
                    drawn.result()
                else:
                    for drawing in drawings:
                        write(drawing, folder, kind)
                return catalogue.clear(folder, kind, drawings)

        return finish


@contextmanager
def _faults_in(folder: Path) -> Iterator[None]:
    """Turn an unwritable folder and a lost process into errors of one line."""
    from queries.database import ResultsError, reason

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


_drawers: ProcessPoolExecutor | None = None
"""In the process that has loaded the plotting library: those forked from it; None where it draws itself."""


def _prepare_loader(workers: int) -> None:
    """Load the plotting library, and fork the processes that draw."""
    global _drawers
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent
    gc.disable()
    importlib.import_module(_PLOTS)
    gc.freeze()  # looking there for garbage would copy memory that processes share
    gc.enable()
    if workers > 1 and "fork" in get_all_start_methods():
        context = get_context("fork")
        _drawers = ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_parent)
        _drawers.submit(int)  # forks all of them, while this process has one thread
    _end_with_parent()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    Thread(target=watch, daemon=True).start()


def _end_drawers() -> None:
    """End the processes that draw: this one waits for them when it ends itself."""
    if _drawers is not None:
        _drawers.shutdown()


def _draw_all(request: _Request, names: Sequence[str]) -> None:
    """Draw figures of a request."""
    if _drawers is None:
        for name in names:
            _draw(request, name)
    else:
        for future in [_drawers.submit(_draw, request, name) for name in names]:
            future.result()


def _draw(request: _Request, name: str) -> None:
    """Draw one figure of a request."""
    from queries.figures.write import write

    write(_drawings(request)[name], request.folder, request.kind)


@lru_cache(1)
def _drawings(request: _Request) -> "dict[str, Drawing]":
    """Return the figures of a request by name, on a connection that stays open for them."""
    from queries.database import connect
    from queries.figures import catalogue

    connection = connect(request.path, bounded=True)
    return {drawing.name: drawing for drawing in catalogue.drawings(connection, request.every)}
