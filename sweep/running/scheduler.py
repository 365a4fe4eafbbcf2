"""Runs the tasks of a plan, in this process or on a Dask cluster, and continues when some of them fail.

A task is handed out when its needs are done, and only a window of tasks at a time, so that the memory of
driver and scheduler does not grow with the sweep. Workers store the results, and return only the outcome of a
task.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from sweep.plan import Plan, Task
from sweep.running.task import Outcome, Place, crash_record, execute
from sweep.storage import records
from sweep.storage.location import NoSpaceError

WINDOW_PER_WORKER = 16
"""Tasks handed out per worker: enough to hide the latency of the scheduler.

The window is refilled when half of it is done, so that the scheduler's cost per submission is small beside
the tasks.
"""

LOST = "its worker died with it, again when it ran alone: out of memory, or a crash in compiled code"


class Crew(Protocol):
    """Runs tasks: this process, or the workers of a cluster."""

    @property
    def size(self) -> int:
        """How many tasks can run at once."""

    def submit(self, tasks: Sequence[Task], place: Place) -> None:
        """Submit tasks."""

    def outcomes(self) -> Iterator[tuple[str, Outcome | None]]:
        """Wait until tasks have finished; yield keys and outcomes, None where workers died with the task."""


class ThisProcess:
    """Runs one task at a time in the driver's process: for debugging and small work."""

    size = 1

    def __init__(self) -> None:
        self._waiting: deque[tuple[Task, Place]] = deque()

    def submit(self, tasks: Sequence[Task], place: Place) -> None:
        """Submit tasks."""
        self._waiting.extend((task, place) for task in tasks)

    def outcomes(self) -> Iterator[tuple[str, Outcome | None]]:
        """Run the next task, with linear algebra on one thread as in a worker."""
        from railvib.numerics import threads

        task, place = self._waiting.popleft()
        with threads.single():
            outcome = execute(task.key, task.units, place)
        yield task.key, outcome


@dataclass
class Tally:
    """Progress of a run."""

    total: int
    done: int = 0
    failed: int = 0
    skipped: int = 0
    damaged: int = 0
    starts: int = 0
    cpu_s: float = 0.0
    bytes_written: int = 0
    peak_rss_bytes: int = 0
    failures: list[tuple[str, str]] = field(default_factory=list)

    @property
    def settled(self) -> int:
        """Tasks that are done, failed, or waited for one that failed."""
        return self.done + self.failed + self.skipped


Report = Callable[[Task, Outcome, Tally], None]


def run(plan: Plan, place: Place, crew: Crew, report: Report) -> Tally:
    """Run the tasks of a plan until each is done, has failed, or needs one that has failed.

    Parameters
    ----------
    plan
        What is missing.
    place
        Where results go.
    crew
        Runs the tasks.
    report
        Called after each task has settled.

    Returns
    -------
    Tally
        `failures` holds key and error of each failed task.

    Raises
    ------
    NoSpaceError
        If a result could not be written; the tasks then running have ended.
    """
    board = _Board(plan.tasks)
    tally = Tally(len(plan.tasks))
    suspects: deque[str] = deque()
    running: set[str] = set()

    def start(keys: Sequence[str], at: Place) -> None:
        if keys:
            running.update(keys)
            tally.starts += len(keys)
            crew.submit([plan.tasks[key] for key in keys], at)

    full = ""
    while True:
        if full and not running:
            raise NoSpaceError(full)
        window = WINDOW_PER_WORKER * crew.size
        if not full and 2 * len(running) <= window:
            start(board.take(window - len(running)), place)
        if not running and suspects:
            # All tasks of a dead worker are suspects: alone, only the culprit dies again.
            start([suspects.popleft()], replace(place, attempt=place.attempt + 1))
            alone = True
        else:
            alone = False
        if not running:
            return tally
        for key, outcome in crew.outcomes():
            running.discard(key)
            if outcome is None and not alone:
                suspects.append(key)
                continue
            task = plan.tasks[key]
            if outcome is not None and outcome.status == "no space":
                full = outcome.error
                continue
            if outcome is None:
                for unit in task.units:
                    records.fail(place.directory, crash_record(unit, place, LOST))
                outcome = Outcome(key, "failed", error=LOST)
            _settle(board, tally, task, outcome)
            report(task, outcome, tally)


def _settle(board: "_Board", tally: Tally, task: Task, outcome: Outcome) -> None:
    """Count a task that has ended, and release or drop those that wait for it."""
    tally.cpu_s += outcome.cpu_s
    tally.bytes_written += outcome.bytes_written
    tally.peak_rss_bytes = max(tally.peak_rss_bytes, outcome.peak_rss_bytes)
    if outcome.status == "done":
        tally.done += 1
        board.release(task.key)
    else:
        tally.failed += 1
        tally.damaged += outcome.status == "damaged"
        tally.skipped += board.drop(task.key)
        tally.failures.append((task.key, outcome.error))


class _Board:
    """Which tasks can start, and which wait for what."""

    def __init__(self, tasks: Mapping[str, Task]) -> None:
        self._waits = {key: len(task.after) for key, task in tasks.items()}
        self._before: dict[str, list[str]] = {}
        for key, task in tasks.items():
            for other in task.after:
                self._before.setdefault(other, []).append(key)
        self._ready = deque(key for key, count in self._waits.items() if count == 0)

    def take(self, most: int) -> list[str]:
        """Return up to `most` tasks that can start: those released last come first."""
        return [self._ready.popleft() for _ in range(min(most, len(self._ready)))]

    def release(self, key: str) -> None:
        """Release the tasks that waited only for this one."""
        released = []
        for other in self._before.pop(key, ()):
            if other not in self._waits:  # dropped, as another task that it needs has failed
                continue
            self._waits[other] -= 1
            if self._waits[other] == 0:
                released.append(other)
        self._ready.extendleft(reversed(released))  # first, while workers have their needs in memory

    def drop(self, key: str) -> int:
        """Drop the tasks that need this one, directly or through others; return how many."""
        dropped = 0
        for other in self._before.pop(key, ()):
            if self._waits.pop(other, None) is not None:
                dropped += 1 + self.drop(other)
        return dropped
