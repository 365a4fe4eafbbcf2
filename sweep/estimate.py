"""What a run will take, from the shapes of its arrays: told before anything runs."""

from collections import Counter
from pathlib import Path

from sweep import units
from sweep.run import Request

WORKER_BYTES = 250 * 2**20
"""A worker process with its libraries and compiled kernels, before any task."""


def describe(request: Request, directory: Path) -> str:
    """Return the plan in plain lines: cases, tasks, what is there already, bytes and memory.

    Parameters
    ----------
    request
        The study with its plan.
    directory
        Where the results would go.
    """
    axes = request.resolved.study.sweep
    counts = [
        f"{len(values)} {name}"
        for name, values in (
            ("soils", axes.soil),
            ("tracks", axes.track),
            ("trains", axes.train),
            ("unevennesses", axes.unevenness),
            ("speeds", axes.speed_kmh),
        )
    ]
    plan = request.plan
    tasks = Counter(task.units[-1].kind for task in plan.tasks.values())
    each = ", ".join(f"{count} {kind}" for kind, count in tasks.items())
    missing = [plan.units[identity] for identity in plan.missing]
    written = sum(units.KINDS[unit.kind].size(unit.inputs) for unit in missing)
    memory = max(
        (
            sum(units.KINDS[unit.kind].memory(unit.inputs) for unit in task.units)
            for task in plan.tasks.values()
        ),
        default=0,
    )
    approaches = request.resolved.study.approaches.compare
    lines = [
        f"study       {request.resolved.study.study.name}, to {directory}",
        f"cases       {len(request.cases)} ({' x '.join(counts)})",
        f"approaches  {len(approaches)} ({', '.join(approaches)})",
        f"results     {len(plan.units)} needed, {len(plan.units) - len(missing)} there already",
    ]
    if not missing:
        return "\n".join([*lines, "tasks       none: everything is there"])
    return "\n".join(
        [
            *lines,
            f"tasks       {len(plan.tasks)} ({each})",
            f"store       {_bytes(written)} to write",
            f"memory      {_bytes(WORKER_BYTES + memory)} per worker at most",
        ]
    )


def _bytes(count: float) -> str:
    """Return a number of bytes with two digits and a unit."""
    for unit in ("B", "kB", "MB", "GB"):
        if count < 1000.0:
            return f"{count:.3g} {unit}"
        count /= 1000.0
    return f"{count:.3g} TB"
