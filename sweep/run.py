"""A run from study to manifest: check the directory, plan, compute what is missing, and say how it went."""

import json
import math
import os
import platform
import secrets
import socket
import time
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import railvib
from railvib.errors import InputError
from sweep import description, plan
from sweep.host import host_class
from sweep.running.lock import LOCK
from sweep.storage import location, records
from sweep.study import Case, Resolved
from sweep.unit import Unit
from sweep.wanted import spectra_unit
from sweep.workers.launch import STAGES, Launch

if TYPE_CHECKING:
    from sweep.running.scheduler import Tally

LIBRARIES = (
    "railvib",
    "numpy",
    "scipy",
    "numba",
    "zarr",
    "dask",
    "distributed",
    "pydantic",
    "xarray",
    "duckdb",
)
DONE, FAILED, INTERRUPTED = 0, 1, 130
MOST_CASES = 200_000
"""Of one study; the plan of a case takes some 54 kB of the driver's memory."""
REPAIRS = 3
"""How often a run plans anew because stored results were found damaged."""


@dataclass(frozen=True)
class Request:
    """A study with its cases and the plan of what it needs.

    Attributes
    ----------
    wanted
        Per case and approach, the unit that holds its result.
    store
        Where results lie that cases share, if not with the run.
    """

    resolved: Resolved
    cases: tuple[Case, ...]
    wanted: Mapping[tuple[str, str], Unit]
    plan: plan.Plan
    store: str | None = None

    def resting_on(self, identities: Set[str]) -> "Request":
        """Return the request with a plan for those results only that rest on one of these units."""
        return replace(self, plan=self.plan.resting_on(identities))


def prepare(resolved: Resolved, directory: Path, store: str | None = None, complete: bool = False) -> Request:
    """Plan a study against what a directory and a store outside hold already; writes nothing.

    Parameters
    ----------
    resolved
        The study.
    directory
        Where its results are or shall be.
    store
        Path or address of the store outside; without one, that of the directory's latest run.
    complete
        Plan also what is missing of what finished results rest on.

    Raises
    ------
    InputError
        If the directory belongs to another study, or to something else, or the store cannot be used.
    """
    check_directory(directory, resolved.study.study.name)
    check_number(resolved)
    store = location.address(store) if store else next(map(str, records.homes(directory)[1:]), None)
    present = records.listed(directory)
    if store:
        location.at(store).check()
        present |= records.listed(store)
    cases = tuple(resolved.cases())
    wanted: dict[tuple[str, str], Unit] = {
        (case.case_id, approach): spectra_unit(resolved, case, approach)
        for case in cases
        for approach in resolved.study.approaches.compare
    }
    made = plan.make(wanted.values(), present, complete)
    return Request(resolved, cases, wanted, made, store)


def check_number(resolved: Resolved) -> None:
    """Check that a study has not more cases than the driver's memory can plan.

    Raises
    ------
    InputError
        Naming the longest axis.
    """
    axes = {name: getattr(resolved.study.sweep, name) for name in type(resolved.study.sweep).model_fields}
    number = math.prod(map(len, axes.values()))
    if number > MOST_CASES:
        longest = max(axes, key=lambda name: len(axes[name]))
        raise InputError(
            f"sweep.{longest}: {len(axes[longest])} values make {number} cases; must be at most {MOST_CASES}:"
            " split this axis over studies that share a --store"
        )


def check_directory(directory: Path, name: str) -> None:
    """Check that a directory is free, or holds earlier runs of the study of this name.

    Raises
    ------
    InputError
        If it does not.
    """
    if not directory.exists() or (
        directory.is_dir() and {path.name for path in directory.iterdir()} <= {LOCK}
    ):
        return
    try:
        other = records.Run.load(directory)["study_name"]
    except (OSError, ValueError, KeyError):
        raise InputError(
            f"--out = {str(directory)!r}: holds something else; must be new, empty or of the study {name!r}"
        ) from None
    if other != name:
        raise InputError(
            f"--out = {str(directory)!r}: is of the study {other!r}; must be new, empty or of {name!r}"
        )


def execute(
    request: Request,
    directory: Path,
    launch: Launch,
    planned: Mapping[str, Any] | None = None,
    cautions: Callable[[], list[str]] = list,
    near_end: Callable[[], None] = lambda: None,
) -> int:
    """Compute what is missing, and leave the manifest; return the exit status.

    Parameters
    ----------
    request
        The study and its plan.
    directory
        Where results go; made if missing.
    launch
        Who computes.
    planned
        What it will take, for the manifest.
    cautions
        Gives what is implausible in the study, as soon as that is known; shown before the first result.
    near_end
        Called when no more tasks are left than can run at once, if there have been more.
    """
    run_id = f"{datetime.now(UTC):%Y%m%dT%H%M%S}-{secrets.token_hex(4)}"
    manifest = _manifest(request, run_id, launch) | {"planned": planned, "measured": None}
    if not request.plan.tasks and _asked_before(manifest, directory):
        return DONE
    directory.mkdir(parents=True, exist_ok=True)
    records.Run.publish(directory, manifest)
    status = INTERRUPTED
    began = time.perf_counter()
    tallies: list[Tally] = []
    try:
        status = _compute(request, directory, run_id, launch, tallies, cautions, near_end)
    except Exception:
        status = FAILED
        raise
    finally:
        measured = _measured(tallies, time.perf_counter() - began)
        manifest |= {"finished": _now(), "exit_status": status, "measured": measured}
        records.Run.publish(directory, manifest)
    return status


def _asked_before(manifest: Mapping[str, Any], directory: Path) -> bool:
    """Return whether the latest run of a directory asked for the same, and got it: then it stands."""
    try:
        latest = records.Run.load(directory)
    except FileNotFoundError:
        return False
    asked = ("study", "cases", "model_version", "parameters", "store")
    return latest["exit_status"] == DONE and all(
        latest.get(name) == json.loads(json.dumps(manifest[name])) for name in asked
    )


def _measured(tallies: Sequence["Tally"], wall_s: float) -> dict[str, Any]:
    """Return what a run took, by the tallies of its plan and of what it had to do again."""
    return {
        "tasks": sum(tally.done + tally.failed for tally in tallies),
        "task_starts": sum(tally.starts for tally in tallies),
        "bytes": sum(tally.bytes_written for tally in tallies),
        "peak_memory_bytes": max((tally.peak_rss_bytes for tally in tallies), default=0),
        "cpu_s": sum(tally.cpu_s for tally in tallies),
        "wall_s": wall_s,
    }


def _compute(
    request: Request,
    directory: Path,
    run_id: str,
    launch: Launch,
    tallies: list["Tally"],
    cautions: Callable[[], list[str]],
    near_end: Callable[[], None],
) -> int:
    """Run the missing tasks, if any, and add a tally of each go.

    Without work there is no cluster, and nothing heavy is imported.
    """
    tasks = request.plan.tasks
    from sweep.progress import Display, Log

    with Log(directory, run_id) as log:
        log.write(
            "planned", cases=len(request.cases), units=len(request.plan.units), tasks=len(tasks), settled=0
        )
        if not tasks:
            log.write("finished", done=0, failed=0, skipped=0)
            return DONE
        from sweep.running import scheduler
        from sweep.running.task import Outcome, Place
        from sweep.storage import store

        store.clean(directory)
        if request.store:
            store.clean(request.store, location.ABANDONED_S)
        place = Place(str(directory.resolve()), run_id, STAGES, store=request.store)
        asked = {unit.id for task in tasks.values() for unit in task.units}
        cases = {unit.id: case_id for (case_id, _), unit in request.wanted.items()}
        with launch.crew(len(tasks), STAGES, directory) as crew, Display(len(tasks)) as display:
            unsaid, to_come = [cautions], [near_end]

            def report(task: plan.Task, outcome: Outcome, tally: scheduler.Tally) -> None:
                while unsaid:  # what is implausible has been found while the first task ran
                    for text in unsaid.pop()():
                        display.warn(text)
                if not tallies or tallies[-1] is not tally:
                    tallies.append(tally)
                display.update(task, outcome, tally)
                while to_come and tally.total - tally.settled <= crew.size:
                    to_come.pop()()
                log.write(
                    outcome.status,
                    task=task.key,
                    cases=sorted({cases[unit.id] for unit in task.units if unit.id in cases}),
                    units=len(task.units),
                    cpu_s=round(outcome.cpu_s, 4),
                    settled=tally.settled,
                    tasks=tally.total,
                    **({"error": outcome.error} if outcome.error else {}),
                    **({"warnings": outcome.warnings} if outcome.warnings else {}),
                )

            tally = scheduler.run(request.plan, place, crew, report)
            for _ in range(REPAIRS):
                if not tally.damaged:
                    break
                # A stored result was found damaged and withdrawn: a new plan makes it again.
                log.write("repairing", tasks=tally.damaged)
                again = prepare(request.resolved, directory, request.store).plan.resting_on(asked)
                tally = scheduler.run(again, place, crew, report)
        store.clean(directory)
        log.write("finished", done=tally.done, failed=tally.failed, skipped=tally.skipped)
    return FAILED if tally.failed else DONE


def _manifest(request: Request, run_id: str, launch: Launch) -> dict[str, Any]:
    """Return the manifest of a run that begins; names stand here, and in no id."""
    resolved = request.resolved
    return {
        "schema": records.SCHEMA,
        "run_id": run_id,
        "study_name": resolved.study.study.name,
        "study": resolved.document(),
        "store": request.store,
        "reference": resolved.study.approaches.reference,
        "versions": {
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in LIBRARIES},
        },
        "model_version": railvib.MODEL_VERSION,
        "host": socket.gethostname(),
        "host_class": host_class(),
        "threads": max(launch.processes, 1),
        "pid": os.getpid(),
        "started": _now(),
        "finished": None,
        "exit_status": None,
        "parameters": resolved.parameters(),
        "unevenness_bands": description.unevenness_bands(resolved),
        "rayleigh_speeds_m_s": description.rayleigh_speeds(resolved),
        "axles": description.axles(resolved),
        "cases": [_case(case, request) for case in request.cases],
    }


def _case(case: Case, request: Request) -> dict[str, Any]:
    approaches = {}
    for approach in request.resolved.study.approaches.compare:
        rests_on = request.plan.closure[request.wanted[case.case_id, approach].id]
        approaches[approach] = [
            {"unit_id": unit.id, "scope": unit.scope}
            for unit in (request.plan.units[identity] for identity in rests_on)
        ]
    return {
        "case_id": case.case_id,
        "soil": case.soil,
        "track": case.track,
        "train": case.train,
        "unevenness": case.unevenness,
        "speed_kmh": case.speed_kmh,
        "labels": [label._asdict() for label in case.labels],
        "units": approaches,
    }


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
