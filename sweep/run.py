"""A run from its plan to its manifest: compute what is missing, and record the outcome."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from railvib import signals
from railvib.signals import INTERRUPTED
from sweep import manifest as manifests
from sweep import plan
from sweep.manifest import DONE, FAILED
from sweep.progress import Display, Log
from sweep.request import Request, prepare
from sweep.storage import location, records
from sweep.workers.launch import STAGES, Launch

if TYPE_CHECKING:
    from sweep.running.scheduler import Tally
    from sweep.running.task import Outcome

REPAIRS = 3
"""How often a run plans again after finding damaged results."""


def execute(
    request: Request,
    directory: Path,
    launch: Launch,
    planned: Mapping[str, Any] | None = None,
    cautions: Callable[[], list[str]] = list,
    near_end: Callable[[], None] = lambda: None,
) -> int:
    """Compute what is missing, and write the manifest; return the exit status.

    Parameters
    ----------
    request
        The study and its plan.
    directory
        Where results go; created if missing.
    launch
        Who computes.
    planned
        The forecast, for the manifest.
    cautions
        Waits for the plausibility warnings, which are shown before the first result.
    near_end
        Called once when the last tasks run, if there were more than can run at once.
    """
    manifest = manifests.begin(request, max(launch.processes, 1), planned)
    if not request.plan.tasks and manifests.stands_already(manifest, directory):
        return DONE
    directory.mkdir(parents=True, exist_ok=True)
    records.Run.publish(directory, manifest)
    status = INTERRUPTED
    started = time.perf_counter()
    tallies: list[Tally] = []
    try:
        with Log(directory, manifest["run_id"]) as log:
            reporter = _Reporter(request, log, tallies, cautions, near_end)
            status = _compute(request, directory, launch, reporter)
    except Exception:
        status = INTERRUPTED if signals.end_requested() else FAILED
        raise
    finally:
        wall_s = time.perf_counter() - started
        records.Run.publish(directory, manifests.end(manifest, status, tallies, wall_s))
    return status


class _Reporter:
    """Passes each settled task on to the display and the log, and calls `near_end` in time."""

    def __init__(
        self,
        request: Request,
        log: Log,
        tallies: list["Tally"],
        cautions: Callable[[], list[str]],
        near_end: Callable[[], None],
    ) -> None:
        self.log = log
        self._tallies = tallies
        self._cautions: list[Callable[[], list[str]]] = [cautions]
        self._near_end: list[Callable[[], None]] = [near_end]
        self._cases = {unit.id: case_id for (case_id, _), units in request.wanted.items() for unit in units}

    def report(
        self, display: Display, size: int, task: plan.Task, outcome: "Outcome", tally: "Tally"
    ) -> None:
        """Report a settled task; `size` tasks can run at once."""
        while self._cautions:  # they were computed while the first task ran
            for text in self._cautions.pop()():
                display.warn(text)
        if not self._tallies or self._tallies[-1] is not tally:
            self._tallies.append(tally)
        display.update(task, outcome, tally)
        while self._near_end and tally.total - tally.settled <= size:
            self._near_end.pop()()
        self.log.write(
            outcome.status,
            task=task.key,
            cases=sorted({self._cases[unit.id] for unit in task.units if unit.id in self._cases}),
            units=len(task.units),
            cpu_s=round(outcome.cpu_s, 4),
            settled=tally.settled,
            tasks=tally.total,
            **({"error": outcome.error} if outcome.error else {}),
            **({"warnings": outcome.warnings} if outcome.warnings else {}),
        )


def _compute(request: Request, directory: Path, launch: Launch, reporter: _Reporter) -> int:
    """Run the missing tasks; without any, start no cluster and import nothing heavy."""
    tasks, log = request.plan.tasks, reporter.log
    log.write("planned", cases=len(request.cases), units=len(request.plan.units), tasks=len(tasks), settled=0)
    if not tasks:
        log.write("finished", done=0, failed=0, skipped=0)
        return DONE
    from sweep.running import scheduler
    from sweep.running.task import Place
    from sweep.storage import store

    store.clean(directory)
    if request.store:
        store.clean(request.store, location.ABANDONED_S)
    place = Place(str(directory.resolve()), log.run_id, STAGES, store=request.store)
    asked = {unit.id for task in tasks.values() for unit in task.units}
    with launch.crew(len(tasks), STAGES, directory) as crew, Display(len(tasks)) as display:

        def report(task: plan.Task, outcome: "Outcome", tally: "Tally") -> None:
            reporter.report(display, crew.size, task, outcome, tally)

        tally = scheduler.run(request.plan, place, crew, report)
        for _ in range(REPAIRS):
            if not tally.damaged:
                break
            # A damaged result was withdrawn; the new plan computes it again.
            log.write("repairing", tasks=tally.damaged)
            again = prepare(request.resolved, directory, request.store).plan.resting_on(asked)
            tally = scheduler.run(again, place, crew, report)
    store.clean(directory)
    log.write("finished", done=tally.done, failed=tally.failed, skipped=tally.skipped)
    return FAILED if tally.failed else DONE
