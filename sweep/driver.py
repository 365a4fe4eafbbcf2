"""The steps of `run` and `resume`: plan, forecast, lock the directory, compute, publish."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import click
import psutil

from railvib import signals
from railvib.errors import printable
from railvib.stages.fe_be_table import FeBeTable
from sweep import cautions, hooks
from sweep.forecast import estimate, pilot
from sweep.manifest import FAILED
from sweep.request import Request, prepare
from sweep.run import execute
from sweep.running import lock
from sweep.storage import location, records
from sweep.storage.verify import withdraw
from sweep.study import Resolved
from sweep.workers import leftovers
from sweep.workers.launch import STAGES, Launch
from sweep.workers.watch import WorkersLostError


@dataclass(frozen=True)
class Prepared:
    """A planned request with its forecast and its directory.

    Attributes
    ----------
    planned
        Forecast of its missing tasks.
    cautions
        Waits for the plausibility warnings, and returns them.
    """

    request: Request
    directory: Path
    planned: estimate.Estimate
    cautions: Callable[[], list[str]] = list


def plan(resolved: Resolved, directory: Path, store: str | None, launch: Launch) -> Prepared:
    """Plan a study and forecast what it takes, while another process checks plausibility.

    Raises
    ------
    InputError
        If the study cannot be computed, or not in this directory.
    """
    request = prepare(resolved, directory, store)
    if not request.plan.tasks:
        return Prepared(request, directory, estimate.Estimate())
    launch.get_ready(STAGES)
    cautions.check_plausibility(resolved)
    pending_cautions = launch.beside(cautions.cautions, resolved)
    return Prepared(request, directory, forecast(request), pending_cautions)


def forecast(request: Request) -> estimate.Estimate:
    """Return the forecast of a request at the rates of this machine."""
    return estimate.estimate(request, _rates(request)) if request.plan.tasks else estimate.Estimate()


def check_fits(prepared: Prepared, workers: int | None) -> None:
    """Refuse a request that does not fit this machine with this many workers; see `estimate.check`.

    Raises
    ------
    InputError
        Names the resource that is too small, and the axis to shorten.
    """
    request = prepared.request
    if request.plan.tasks:
        memory = psutil.virtual_memory().total
        estimate.check(request, prepared.planned, _rates(request), prepared.directory, workers, memory)


def _rates(request: Request) -> pilot.Rates:
    tasks = request.plan.tasks.values()
    return pilot.rates(any(isinstance(unit.stage, FeBeTable) for task in tasks for unit in task.units))


def drive(prepared: Prepared, launch: Launch, mend: bool = False, only_failed: bool = False) -> int:
    """Compute what is missing and publish the results; return the exit status.

    Parameters
    ----------
    prepared
        The request and where it goes.
    launch
        Who computes.
    mend
        Withdraw what is damaged first, so that it is computed again.
    only_failed
        Compute only what has failed, and what waited for it.
    """
    directory = prepared.directory
    if prepared.request.plan.tasks or mend:
        launch.check(directory, prepared.request.store)
    try:
        with lock.hold(directory) as predecessor:
            if predecessor:
                leftovers.discard_keys(directory)
                click.echo(f"{predecessor} exited unexpectedly; its results are kept", err=True)
            if mend or only_failed:
                prepared = _renew(prepared, mend, only_failed)
            exit_status = _compute_and_publish(prepared, launch)
    except (KeyboardInterrupt, Exception) as error:
        resume = f"continue with: railvib resume {directory}"
        if isinstance(error, KeyboardInterrupt) or signals.end_requested():
            click.echo(f"interrupted; what is done is kept; {resume}", err=True)
            return signals.INTERRUPTED
        if isinstance(error, WorkersLostError):
            click.echo(f"{error}; what is done is kept; {resume}", err=True)
            return FAILED
        if location.is_full(error):
            whole = f"{directory}: {error}; what was stored before is whole"
            click.echo(f"{whole}; make space, and {resume}", err=True)
            return FAILED
        raise
    if exit_status == FAILED:
        click.echo(f"some tasks failed; see: railvib status {directory}", err=True)
    return exit_status


def _renew(prepared: Prepared, mend: bool, only_failed: bool) -> Prepared:
    """Plan the request again: after withdrawing damaged results, or for failed ones only."""
    request, directory = prepared.request, prepared.directory
    if mend:
        _withdraw_damage(request, directory)
        request = prepare(request.resolved, directory, request.store, complete=True)
    if only_failed:
        request = request.resting_on({record["unit_id"] for record in records.failures(directory)})
    return Prepared(request, directory, forecast(request), prepared.cautions)


def _withdraw_damage(request: Request, directory: Path) -> None:
    for damage in withdraw(directory, request.plan.units.values()):
        click.echo(f"damaged: {printable(str(damage))}; it is computed again", err=True)
    hooks.published_faults(directory, repair=True)


def _compute_and_publish(prepared: Prepared, launch: Launch) -> int:
    request, directory = prepared.request, prepared.directory
    counts = f"{len(request.cases)} cases, {len(request.plan.units)} units, {len(request.plan.tasks)} tasks"
    click.echo(f"{counts} to run", err=True)
    with ExitStack() as stack:
        publishers = [stack.enter_context(publisher) for publisher in hooks.publishers(directory)]

        def near_end() -> None:
            for publisher in publishers:
                publisher.get_ready()

        planned = prepared.planned.document
        exit_status = execute(request, directory, launch, planned, prepared.cautions, near_end)
        for publisher in publishers:
            publisher.publish()
    return exit_status
