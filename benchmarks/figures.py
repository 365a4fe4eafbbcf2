"""Figures of the benchmark with their samples, and the way from a call to samples."""

import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

SAMPLE_S = 0.02
"""Shortest duration of a sample: shorter calls are repeated within it."""


@dataclass(frozen=True)
class Figure:
    """One measured or derived quantity.

    Attributes
    ----------
    section, item, case, quantity
        The part of the benchmark, the thing measured, the conditions, and which of its quantities.
    unit
        Unit of the samples.
    samples
        Values, one per repetition; a derived quantity has one.
    at_least, at_most
        The target, if there is one.
    """

    section: str
    item: str
    case: str
    quantity: str
    unit: str
    samples: tuple[float, ...]
    at_least: float | None = None
    at_most: float | None = None

    @property
    def median(self) -> float:
        """Median of the samples."""
        return float(np.median(self.samples))

    def quantile(self, share: float) -> float:
        """Return the value below which this share of the samples lies."""
        return float(np.quantile(self.samples, share))

    @property
    def holds(self) -> bool | None:
        """Whether the median meets the target; None without a target."""
        if self.at_least is None and self.at_most is None:
            return None
        return (self.at_least is None or self.median >= self.at_least) and (
            self.at_most is None or self.median <= self.at_most
        )

    def document(self) -> dict[str, Any]:
        """Return the figure for JSON, with median and quartiles."""
        return {
            **asdict(self),
            "median": self.median,
            "lower_quartile": self.quantile(0.25),
            "upper_quartile": self.quantile(0.75),
            "holds": self.holds,
        }


@dataclass(frozen=True)
class Timing:
    """Wall and CPU seconds of one call, a value per sample."""

    wall_s: tuple[float, ...]
    cpu_s: tuple[float, ...]

    @property
    def cpu(self) -> float:
        """Median of the CPU seconds."""
        return float(np.median(self.cpu_s))

    def figures(self, section: str, item: str, case: str, at_most: float | None = None) -> list[Figure]:
        """Return CPU and wall seconds as figures; the target is one for CPU seconds."""
        return [
            Figure(section, item, case, "cpu", "s", self.cpu_s, at_most=at_most),
            Figure(section, item, case, "wall", "s", self.wall_s),
        ]


def time_call(call: Callable[[], object], samples: int, sample_s: float = SAMPLE_S) -> Timing:
    """Measure a call after a first one that warms caches; CPU seconds are of this process, all threads."""
    once = _seconds(call)
    if once < sample_s:  # the first call may have compiled
        once = _seconds(call)
    repetitions = max(1, int(np.ceil(sample_s / max(once, 1e-7))))
    walls, cpus = [], []
    for _ in range(samples):
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(repetitions):
            call()
        walls.append((time.perf_counter() - wall) / repetitions)
        cpus.append((time.process_time() - cpu) / repetitions)
    return Timing(tuple(walls), tuple(cpus))


def _seconds(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def slope(x: Iterable[float], y: Iterable[float]) -> float:
    """Return the exponent p of y ∝ xᵖ by least squares on log-log axes."""
    return float(np.polyfit(np.log(np.array([*x], float)), np.log(np.array([*y], float)), 1)[0])
