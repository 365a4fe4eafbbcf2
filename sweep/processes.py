"""Processes of this machine as the engine's crew.

Each computes one task at a time, so that a crash takes one with it. They are forked from a process that has
loaded everything, see `sweep.prefork`, and end with the driver.
"""

import importlib
import os
import signal
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from threading import Thread
from typing import Any

import psutil

from sweep import prefork
from sweep.plan import Task
from sweep.task import Outcome, Place, execute

TRIES = 2
"""How often a task starts before it is told that its processes have died with it."""
PATIENCE_S = 5.0
"""How long a process may take to end."""


@dataclass
class _Work:
    """A task that waits or runs, and how often it has started."""

    task: Task
    place: Place
    tries: int = 0


class _Worker:
    """A process, the pipe to it, and what it computes."""

    def __init__(self, kinds: str) -> None:
        context = get_context("forkserver")
        self.work: _Work | None = None
        self.pipe, theirs = context.Pipe()
        environment = {**os.environ, **prefork.THREADS}  # the one that is forked may be older
        self.process = context.Process(target=_serve, args=(theirs, kinds, environment), daemon=True)
        self.process.start()
        theirs.close()

    def start(self, work: _Work) -> None:
        """Hand a task to the process, which has none."""
        work.tries += 1
        self.work = work
        self.say((work.task.key, work.task.units, work.place))

    def say(self, message: Any) -> None:
        """Send something; that the process has died is seen when it does not answer."""
        with suppress(OSError):
            self.pipe.send(message)

    def answer(self) -> Outcome | None:
        """Wait for an answer; there is none from a process that has died."""
        try:
            outcome: Outcome | None = self.pipe.recv()
        except (EOFError, OSError):
            return None
        return outcome

    def end(self) -> None:
        """Let the process end, at once if it computes something: nobody wants that any more."""
        self.pipe.close()
        if self.work is not None:
            self.process.terminate()

    def gone(self) -> None:
        """Wait until the process has ended."""
        self.process.join(PATIENCE_S)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()


class Processes:
    """So many processes that compute the kinds of a module."""

    def __init__(self, number: int, kinds: str) -> None:
        self._kinds = kinds
        self._waiting: deque[_Work] = deque()
        first = _Worker(kinds)
        first.say(None)
        first.answer()  # what is not compiled is now: two processes that do so at once can crash
        self._workers = [first, *(_Worker(kinds) for _ in range(number - 1))]

    @property
    def size(self) -> int:
        """How many tasks can run at once."""
        return len(self._workers)

    def processor_seconds(self) -> list[float]:
        """Return what each process has used of processor time so far [s]."""
        return [sum(psutil.Process(each.process.pid).cpu_times()[:2]) for each in self._workers]

    def submit(self, tasks: Sequence[Task], place: Place) -> None:
        """Hand tasks out."""
        self._waiting.extend(_Work(task, place) for task in tasks)

    def finished(self) -> Iterator[tuple[str, Outcome | None]]:
        """Wait for at least one task; others have begun before it is told."""
        ended: list[tuple[str, Outcome | None]] = []
        while not ended:
            self._start()
            busy = [place for place, each in enumerate(self._workers) if each.work is not None]
            ready = wait([self._workers[place].pipe for place in busy])
            for place in [place for place in busy if self._workers[place].pipe in ready]:
                ended += self._settle(place)
        self._start()
        yield from ended

    def _start(self) -> None:
        """Give every process that has nothing to do the next task."""
        for worker in self._workers:
            if worker.work is None and self._waiting:
                worker.start(self._waiting.popleft())

    def _settle(self, place: int) -> list[tuple[str, Outcome | None]]:
        """Return what became of a process's task, or nothing if it shall run again: then the process died."""
        worker = self._workers[place]
        work, outcome = worker.work, worker.answer()
        assert work is not None
        if outcome is not None:
            worker.work = None
            return [(work.task.key, outcome)]
        worker.end()
        worker.gone()
        self._workers[place] = _Worker(self._kinds)
        if work.tries < TRIES:
            self._waiting.appendleft(work)
            return []
        return [(work.task.key, None)]

    def end(self) -> None:
        """Let all processes end, and wait for that."""
        for worker in self._workers:
            worker.end()
        for worker in self._workers:
            worker.gone()


@contextmanager
def local(number: int, kinds: str) -> Iterator[Processes]:
    """Start processes on this machine, and stop them at the end whatever happens.

    Parameters
    ----------
    number
        How many.
    kinds
        The module whose kinds they will run.
    """
    prefork.start(kinds)
    crew = Processes(number, kinds)
    try:
        yield crew
    finally:
        crew.end()


def _serve(tasks: Connection, kinds: str, environment: dict[str, str]) -> None:
    """Compute one task after the other until the driver wants no more."""
    os.environ.clear()
    os.environ.update(environment)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends it to all: the driver stops its processes
    Thread(target=_end_with_driver, daemon=True).start()
    with suppress(Exception):  # whatever is wrong will be wrong in the first task as well, and be told there
        importlib.import_module(kinds).warm_up()
    with suppress(EOFError, OSError):
        while True:
            given = tasks.recv()
            tasks.send(None if given is None else _outcome(*given))


def _outcome(key: str, units: Sequence[Any], place: Place) -> Outcome:
    """Return what became of a task; an exception here is the engine's or the machine's."""
    try:
        return execute(key, units, place)
    except Exception as error:
        return Outcome(key, "failed", error=f"{type(error).__name__}: {error}".partition("\n")[0])


def _end_with_driver() -> None:
    """End this process when the driver has been killed."""
    driver = parent_process()
    assert driver is not None
    driver.join()
    os._exit(1)
