"""What a computation costs: wall and CPU seconds, counted evaluations and peak memory, stage by stage.

The physics names its stages (`with cost.stage("fit") as spent: spent.evaluations += n`); whoever wants to
know collects them. Without a collector a stage costs about a microsecond and is forgotten. Stages of one name
add up; a stage inside another one is taken out of that, so that the stages' sum is the whole.
"""

import resource
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

RSS_UNIT = 1 if sys.platform == "darwin" else 1024
"""Bytes per unit of the resident memory that `getrusage` reports."""


@dataclass
class StageCost:
    """What the passes through one stage cost together.

    Attributes
    ----------
    wall_s, cpu_s
        Elapsed and processor seconds of this process [s].
    evaluations
        Values of a transfer function that were computed, one per frequency and wavenumber.
    kernel_calls
        Calls of a compiled kernel.
    peak_rss_bytes
        Largest resident memory of the process seen so far at the end of a pass [byte].
    """

    stage: str
    wall_s: float = 0.0
    cpu_s: float = 0.0
    evaluations: int = 0
    kernel_calls: int = 0
    peak_rss_bytes: int = 0


_collected: ContextVar[list[StageCost] | None] = ContextVar("collected", default=None)


@contextmanager
def collect() -> Iterator[list[StageCost]]:
    """Gather the costs of every stage passed inside the block; the list fills as stages end."""
    costs: list[StageCost] = []
    token = _collected.set(costs)
    try:
        yield costs
    finally:
        _collected.reset(token)


class stage:
    """Time one stage, and let its body add what it counts."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __enter__(self) -> StageCost:
        """Start the clocks and return the entry to count into."""
        self._spent = StageCost(self._name)
        self._around = _running.get()
        self._inner_wall_s = self._inner_cpu_s = 0.0
        _running.set(self)
        self._cpu = time.process_time()
        self._wall = time.perf_counter()
        return self._spent

    def __exit__(self, *_: object) -> None:
        """Stop the clocks, also when the body raised, and add to the stage's sum."""
        _running.set(self._around)
        wall_s, cpu_s = time.perf_counter() - self._wall, time.process_time() - self._cpu
        if self._around is not None:
            self._around._inner_wall_s += wall_s
            self._around._inner_cpu_s += cpu_s
        costs = _collected.get()
        if costs is None:
            return
        self._spent.wall_s = wall_s - self._inner_wall_s
        self._spent.cpu_s = cpu_s - self._inner_cpu_s
        self._spent.peak_rss_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * RSS_UNIT
        add(costs, self._spent)


_running: ContextVar[stage | None] = ContextVar("running", default=None)


def add(costs: list[StageCost], spent: StageCost) -> None:
    """Add one pass to the entry of its stage, which is made where it is missing."""
    for entry in costs:
        if entry.stage == spent.stage:
            entry.wall_s += spent.wall_s
            entry.cpu_s += spent.cpu_s
            entry.evaluations += spent.evaluations
            entry.kernel_calls += spent.kernel_calls
            entry.peak_rss_bytes = max(entry.peak_rss_bytes, spent.peak_rss_bytes)
            return
    costs.append(StageCost(**vars(spent)))
