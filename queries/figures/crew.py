"""Processes that draw figures while other work goes on."""

import gc
import importlib
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_all_start_methods, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path
from threading import Thread

WORKERS = min(os.cpu_count() or 1, 4)
"""Processes that draw."""


@dataclass(frozen=True)
class _Order:
    """The figures of a database, into a folder, in a format: the paper's, or `every` one."""

    path: Path
    folder: Path
    kind: str
    every: bool


class Crew:
    """Processes that draw figures, forked from one that loads the plotting library when a crew is made.

    Parameters
    ----------
    workers
        How many draw; 0 draws in this process.
    """

    def __init__(self, workers: int) -> None:
        self._pipe: Connection | None = None
        if workers:
            kinds = get_all_start_methods()
            context = get_context("forkserver") if "forkserver" in kinds else get_context("spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs, workers if "fork" in kinds else 1))
            self._process.start()
            theirs.close()

    def __enter__(self) -> "Crew":
        """Return itself; leaving the block waits for the processes to end."""
        return self

    def __exit__(self, *_: object) -> None:
        if self._pipe is not None:
            self._pipe.close()
            self._process.join()

    def start(
        self, path: Path, folder: Path, kind: str = "png", every: bool = False
    ) -> Callable[[], list[Path]]:
        """Begin to draw the figures of a database into a folder.

        Parameters
        ----------
        path
            The database.
        folder
            Made if missing.
        kind
            png, svg or pdf.
        every
            Not those of the paper alone.

        Returns
        -------
        Waits until all are drawn and returns their files; those of an earlier state are gone then.
        """
        folder.mkdir(parents=True, exist_ok=True)
        order, pipe = _Order(path, folder, kind, every), self._pipe
        if pipe is not None:
            pipe.send(order)
        drawn = _drawn(order) if pipe is None else {}

        def finish() -> list[Path]:
            answer = drawn if pipe is None else pipe.recv()
            if isinstance(answer, BaseException):
                raise answer
            files = [answer[place] for place in sorted(answer)]
            for old in set(folder.glob(f"figure-[0-9][0-9]-*.{kind}")) - set(files):
                old.unlink()
            return files

        return finish


def _serve(orders: Connection, workers: int) -> None:
    """Load the plotting library, and carry out orders until there are no more."""
    gc.disable()
    importlib.import_module("queries.figures.plots")
    gc.freeze()  # what is loaded stays: nobody need look there for garbage
    gc.enable()
    while True:
        try:
            order = orders.recv()
        except EOFError:
            return
        try:
            orders.send(_shared(order, workers) if workers > 1 else _drawn(order))
        except Exception as error:
            orders.send(error)


def _shared(order: _Order, workers: int) -> dict[int, Path]:
    """Draw in several processes: each takes the next figure when it has done one."""
    context = get_context("fork")  # this process has one thread, and no database open
    turn = context.Value("i", 0)
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=(turn,)) as pool:
        parts = [pool.submit(_drawn, order) for _ in range(workers)]
        _end_with_parent()
        return {place: file for part in parts for place, file in part.result().items()}


_turn: "Synchronized[int] | None" = None
"""How many figures have been taken by the processes that share an order."""


def _begin(turn: "Synchronized[int]") -> None:
    global _turn
    _turn = turn
    _end_with_parent()


def _end_with_parent() -> None:
    """Let this process end when the one that it draws for has been killed; it would wait for ever."""
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    Thread(target=watch, daemon=True).start()


def _drawn(order: _Order) -> dict[int, Path]:
    """Draw what no other process has taken; return the files by their places in the list of figures."""
    from queries.database import connection as database
    from queries.figures import figures

    done: dict[int, Path] = {}
    with database.attach(order.path, bounded=True) as connection:
        planned = figures.drawings(connection, order.every)
        # The last figures have the most panels: they come first, lest one process end long after the others.
        waiting = list(enumerate(planned))[::-1]
        taken = 0
        while True:
            if _turn is not None:
                with _turn.get_lock():
                    taken, _turn.value = _turn.value, _turn.value + 1
            if taken >= len(waiting):
                return done
            place, drawing = waiting[taken]
            done[place] = order.folder / f"{drawing.name}.{order.kind}"
            figures.write(drawing, done[place], order.kind)
            taken += 1
