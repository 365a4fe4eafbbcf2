"""Forecast of a run before it starts; what does not fit this machine is refused."""

import shutil
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from railvib.errors import InputError
from railvib.stages import Stage
from sweep.forecast.pilot import Rates
from sweep.request import Request
from sweep.storage.cache import CACHE_BYTES
from sweep.unit import Unit, work

MARGIN = 1.15
"""Factor on the memory of arrays, for fragmentation."""
FIRST_BYTES = 16 * 2**20
"""Memory that an idle worker touches for the first time when it computes anything."""
CACHE_SHARE = 2
"""Largest memory of a cached result over its stored size: data derived from it is kept too."""
DATABASE_SHARE = 1.5
"""Disk of a run over that of its arrays: records and the database come on top."""
LONGEST_S = 365.25 * 86400.0
"""Wall seconds beyond which a run is refused."""


@dataclass(frozen=True)
class Estimate:
    """Forecast of the missing part of a study.

    Attributes
    ----------
    tasks
        Number of missing tasks.
    bytes
        Size of their results in the store.
    peak_memory_bytes
        Largest memory of a worker.
    cpu_s
        Processor seconds of the workers.
    pilot_s
        Processor seconds of the pilot that measured the rates.
    """

    tasks: int = 0
    bytes: int = 0
    peak_memory_bytes: int = 0
    cpu_s: float = 0.0
    pilot_s: float = 0.0

    @property
    def document(self) -> dict[str, Any]:
        """The numbers as the manifest has them."""
        return asdict(self)


def estimate(request: Request, rates: Rates) -> Estimate:
    """Return the forecast of the missing tasks of a request on this machine."""
    plan = request.plan
    if not plan.tasks:
        return Estimate()
    stored = sum(_sizes(request).values())
    memory = max(_memory(task.units) for task in plan.tasks.values())
    needed = sum(unit.stage.nbytes() for unit in plan.units.values())
    cached = CACHE_SHARE * min(CACHE_BYTES, needed)
    return Estimate(
        tasks=len(plan.tasks),
        bytes=stored,
        peak_memory_bytes=int(rates.idle_bytes + FIRST_BYTES + MARGIN * (cached + memory)),
        cpu_s=sum(_cpu(request, rates).values()),
        pilot_s=rates.pilot_s,
    )


def check(
    request: Request, planned: Estimate, rates: Rates, directory: Path, workers: int | None, memory: int
) -> None:
    """Refuse a request that cannot fit.

    Parameters
    ----------
    request, planned, rates
        The study, its forecast, and the rates behind it.
    directory
        Where results go.
    workers
        Processes that compute on this machine; None where other machines do, whose memory is unknown.
    memory
        Of this machine, bytes.

    Raises
    ------
    InputError
        Names the resource that is too small, and the axis to shorten.
    """
    if not planned.tasks:
        return
    place = _nearest(directory)
    free = shutil.disk_usage(place).free
    wanted = DATABASE_SHARE * planned.bytes
    if wanted > free:
        raise InputError(
            f"{_largest_axis(request, _sizes(request))} makes most of {_bytes(wanted)} of results; "
            f"{place} has {_bytes(free)} free: cut that axis, or choose another place"
        )
    if workers is None:
        return
    needed, available = _bytes(planned.peak_memory_bytes), _bytes(memory)
    if planned.peak_memory_bytes > memory:
        raise InputError(
            f"{_hungriest(request)} makes a worker need {needed} of memory; this machine has {available}: "
            "cut that axis"
        )
    if workers * planned.peak_memory_bytes > memory:
        raise InputError(
            f"--workers = {workers}: each may need {needed} of memory, and this machine has {available}; "
            f"must be at most {memory // planned.peak_memory_bytes}"
        )
    wall = planned.cpu_s / workers
    if wall > LONGEST_S:
        raise InputError(
            f"{_largest_axis(request, _cpu(request, rates))} makes most of {_duration(planned.cpu_s)} of "
            f"processor time, {_duration(wall)} with --workers = {workers}; must be at most a year: "
            "cut that axis"
        )


def describe(request: Request, planned: Estimate, directory: Path, workers: int | None) -> str:
    """Return the plan in plain lines: cases, tasks, results present, bytes, memory and time."""
    study = request.resolved.study
    axes = study.sweep
    counts = [
        f"{number} {one if number == 1 else several}"
        for one, several, number in (
            ("soil", "soils", len(set(axes.soil))),
            ("track", "tracks", len(set(axes.track))),
            ("train", "trains", len(set(axes.train))),
            ("unevenness spectrum", "unevenness spectra", len(set(axes.unevenness))),
            ("speed", "speeds", len(set(axes.speed_kmh))),
        )
    ]
    plan = request.plan
    approaches = study.approaches.compare
    lines = [
        *([f"title       {study.study.title}"] if study.study.title else []),
        f"study       {study.study.name}, to {directory}",
        f"cases       {len(request.cases)} ({' x '.join(counts)})",
        f"approaches  {len(approaches)} ({', '.join(approaches)})",
        f"results     {len(plan.units)} needed, {len(plan.units) - len(plan.missing)} there already",
    ]
    if not plan.tasks:
        return "\n".join([*lines, "tasks       none: everything is there"])
    tasks_of = Counter(task.units[-1].stage_name for task in plan.tasks.values())
    by_stage = ", ".join(f"{count} {stage}" for stage, count in tasks_of.items())
    wall = f", {_duration(planned.cpu_s / workers)} with {workers} workers" if workers else ""
    return "\n".join(
        [
            *lines,
            f"tasks       {len(plan.tasks)} ({by_stage})",
            f"store       {_bytes(planned.bytes)} to write",
            f"memory      {_bytes(planned.peak_memory_bytes)} per worker at most",
            f"processor   {_duration(planned.cpu_s)}{wall}, from a pilot of {planned.pilot_s:.1f} s",
        ]
    )


def _sizes(request: Request) -> Counter[type[Stage]]:
    """Return the bytes of missing results, by stage."""
    amounts: Counter[type[Stage]] = Counter()
    for identity in request.plan.missing:
        unit = request.plan.units[identity]
        amounts[type(unit.stage)] += unit.stage.nbytes()
    return amounts


def _cpu(request: Request, rates: Rates) -> Counter[type[Stage]]:
    """Return the processor seconds of missing results, by stage."""
    amounts: Counter[type[Stage]] = Counter()
    for task in request.plan.tasks.values():
        amounts[type(task.units[0].stage)] += rates.of(work(task.units))  # type: ignore[assignment]
    return amounts


def _memory(task: tuple[Unit, ...]) -> int:
    """Estimate the memory of a task from its most demanding units."""
    memory = sorted((unit.stage.memory() for unit in task), reverse=True)
    return sum(memory[: task[0].stage.at_once])


def _largest_axis(request: Request, by_stage: Mapping[type[Stage], float]) -> str:
    """Return the axis that saves most when cut to one value, with its number of values.

    Where every axis has one value, it is the longest train that makes the work.
    """
    study = request.resolved.study
    values: dict[str, Any] = {
        **{name: getattr(study.sweep, name) for name in type(study.sweep).model_fields},
        "offsets_m": study.receivers.offsets_m,
    }

    def saving(axis: str) -> float:
        part = sum(amount for stage, amount in by_stage.items() if axis in stage.grows_with)
        return part * (1.0 - 1.0 / max(len(values[axis]), 1))

    axis = max(values, key=saving)
    if saving(axis) == 0.0:
        trains: Mapping[str, Any] = request.resolved.objects["train"]
        longest = max(set(study.sweep.train), key=lambda name: trains[name].axle_count)
        return f"sweep.train = {longest!r} ({trains[longest].axle_count} axles)"
    section = "receivers" if axis == "offsets_m" else "sweep"
    return f"{section}.{axis} ({len(values[axis])} values)"


def _hungriest(request: Request) -> str:
    """Return the axis, and its value, behind the task that needs most memory."""
    task = max(request.plan.tasks.values(), key=lambda task: _memory(task.units))
    stage, resolved = task.units[0].stage, request.resolved
    axis = stage.memory_grows_with()
    if axis is not None:
        value = getattr(stage, axis)
        name = next(name for name, known in resolved.objects[axis].items() if known == value)
        return f"sweep.{axis} = {name!r} ({value.axle_count} axles)"
    if resolved.study.receivers.offsets_m:
        farthest = max(resolved.study.receivers.offsets_m)
        return f"receivers.offsets_m = {farthest:g} m"
    return f"frequency.maximum_hz = {resolved.study.frequency.maximum_hz:g} Hz"


def _nearest(directory: Path) -> Path:
    """Return the directory, or its nearest parent that exists."""
    return next(path for path in (directory.absolute(), *directory.absolute().parents) if path.exists())


def _bytes(count: float) -> str:
    """Return a number of bytes with two digits and a unit."""
    for unit in ("B", "kB", "MB", "GB"):
        if count < 1000.0:
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return f"{count:.3g} TB"


def _duration(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    for unit, size in (("years", 365.25 * 86400.0), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
