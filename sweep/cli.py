"""The engine's sub-commands: plan, run, status and resume.

What they need is imported when they run, so that asking for help, or for what is done already, stays quick.
"""

import gc
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import click

from railvib.errors import InputError, PlausibilityWarning

if TYPE_CHECKING:
    from sweep.forecast.estimate import Estimate
    from sweep.forecast.pilot import Rates
    from sweep.run import Request
    from sweep.study import Resolved
    from sweep.workers.launch import Launch

AFTER_RUN = "railvib.after_run"
"""Group of entry points that publish results: called with a run directory each gives a `Publisher`."""
VERIFY = "railvib.verify"
STUDY = click.Path(dir_okay=False, path_type=Path)
_RUNS = Path("runs")
DIRECTORY = click.Path(file_okay=False, path_type=Path)


class Publisher(AbstractContextManager[Any], Protocol):
    """Publishes the results of a run; leaving its context ends all that it has started."""

    def get_ready(self) -> None:
        """Begin with what publishing needs; called once no task waits any more, and does not wait."""

    def publish(self) -> None:
        """Publish what is there when a run has ended."""


STORED = click.option(
    "--store",
    metavar="PATH-OR-URL",
    help="Keep what cases share outside the run, for many studies: a folder, or s3://BUCKET/PREFIX.",
)


def computing(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of commands that compute."""
    for option in (
        click.option("--dashboard", is_flag=True, help="Serve Dask's dashboard on the loopback address."),
        click.option(
            "--cluster", type=STUDY, metavar="FILE", help="Start workers where FILE says: by SSH, or as jobs."
        ),
        click.option("--tls-key", metavar="FILE", help="Private key, if not in the file of --tls-cert."),
        click.option("--tls-cert", metavar="FILE", help="Our certificate for a scheduler at tls://…"),
        click.option("--tls-ca", metavar="FILE", help="Whose certificates to trust at tls://…"),
        click.option(
            "--scheduler",
            metavar="ADDRESS",
            help="Use the workers of a Dask scheduler, tcp://HOST:PORT or tls://HOST:PORT.",
        ),
        click.option(
            "--workers",
            type=click.IntRange(min=0),
            metavar="N",
            help="Processes to start here; 0 computes in this process. Default: one per processor.",
        ),
    ):
        command = option(command)
    return command


@click.command()
@click.argument("study", type=STUDY)
@click.option("--out", type=DIRECTORY, help="Output directory that a run would use. Default: runs/<study>.")
@STORED
def plan(study: Path, out: Path | None, store: str | None) -> None:
    """Show what running STUDY takes: cases, tasks, what is there already, bytes, memory, processor time.

    Processor time and memory are those of this machine, by a pilot of a few seconds, which is remembered. A
    study that cannot fit is refused.
    """
    from sweep.forecast import estimate
    from sweep.run import prepare
    from sweep.workers.launch import Launch

    resolved = _load(study)
    directory = out or _default_directory(resolved)
    request = prepare(resolved, directory, store)
    for text in _check_plausibility(resolved, Launch(workers=0))():
        click.echo(f"warning: {text}", err=True)
    here = Launch().here
    planned = _estimate(request)
    click.echo(estimate.describe(request, planned, directory, here))
    _check_fits(request, planned, directory, here)


@click.command()
@click.argument("study", type=STUDY)
@click.option("--out", type=DIRECTORY, help="Output directory. Default: runs/<study>.")
@STORED
@computing
def run(study: Path, out: Path | None, store: str | None, **launch: Any) -> None:
    """Compute what is missing of STUDY, and publish the results."""
    with _collecting_later():
        launched = _launch(launch, out or _RUNS / study.stem)
        resolved = _load(study)
        directory = out or _default_directory(resolved)
        request, planned, cautions = _prepare(resolved, directory, store, launched)
    _run(request, planned, directory, launched, cautions)


@click.command()
@click.argument("directory", type=DIRECTORY)
@click.option("--failed", is_flag=True, help="Only what has failed, and what waited for it.")
@STORED
@computing
def resume(directory: Path, failed: bool, store: str | None, **launch: Any) -> None:
    """Compute what is missing, damaged or failed of the latest run in DIRECTORY."""
    with _collecting_later():
        launched = _launch(launch, directory)
        request, planned, cautions = _prepare(_latest(directory), directory, store, launched)
    _run(request, planned, directory, launched, cautions, mend=True, only_failed=failed)


@click.command()
@click.argument("directory", type=DIRECTORY)
@click.option("--verify", is_flag=True, help="Read all results, and compare them with their checksums.")
def status(directory: Path, verify: bool) -> None:
    """Show how far the latest run in DIRECTORY is, and what failed."""
    from sweep import status as state

    manifest = _manifest(directory)
    for line in state.describe(directory, manifest):
        click.echo(line)
    faults = _faults(directory) if verify else []
    if verify:
        click.echo(f"damaged   {len(faults)}")
    for fault in faults:
        click.echo(f"  {fault}")
    if (faults or manifest["exit_status"] != 0) and not state.alive(directory):
        click.echo(f"continue with: railvib resume {directory}")
    sys.exit(1 if faults else 0)


def _faults(directory: Path) -> list[str]:
    """Return what is damaged of all that the latest run in a directory rests on, in a line each."""
    from sweep.run import prepare
    from sweep.storage.verify import damaged

    needed = prepare(_latest(directory), directory).plan.units.values()
    found = [str(each) for each in damaged(directory, needed)]
    if _manifest(directory)["finished"] is None:  # nothing has been published yet
        return found
    return found + [fault for hook in metadata.entry_points(group=VERIFY) for fault in hook.load()(directory)]


@contextmanager
def _collecting_later() -> Iterator[None]:
    """Leave garbage alone meanwhile: a fifth of the time to import all that a run needs goes into it."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _launch(launch: Mapping[str, Any], directory: Path) -> "Launch":
    """Return who computes; where there has been no run, workers are made ready while it is planned."""
    from sweep.storage import records
    from sweep.workers.launch import STAGES, Launch

    launched = Launch(**launch)
    if not (directory / records.MANIFEST).exists():
        launched.get_ready(STAGES)
    return launched


def _prepare(
    resolved: "Resolved", directory: Path, store: str | None, launched: "Launch"
) -> tuple["Request", "Estimate", Callable[[], list[str]]]:
    """Plan a study and refuse what cannot be; return also what waits for what is implausible in it."""
    from sweep.forecast.estimate import Estimate
    from sweep.run import prepare
    from sweep.workers.launch import STAGES

    request = prepare(resolved, directory, store)
    if not request.plan.tasks:
        return request, Estimate(), list
    launched.get_ready(STAGES)
    cautions = _check_plausibility(resolved, launched)
    planned = _estimate(request)
    _check_fits(request, planned, directory, launched.here)
    return request, planned, cautions


def _run(
    request: "Request",
    planned: "Estimate",
    directory: Path,
    launched: "Launch",
    cautions: Callable[[], list[str]],
    mend: bool = False,
    only_failed: bool = False,
) -> None:
    """Compute, publish, and leave with the exit status."""
    from sweep.run import FAILED, INTERRUPTED, execute, prepare
    from sweep.running import lock
    from sweep.storage import location, records

    if request.plan.tasks or mend:
        launched.check(directory, request.store)
    try:
        with lock.hold(directory) as dead, _stoppable():
            if dead:
                click.echo(f"{dead} exited unexpectedly; its results are kept", err=True)
            if mend:
                _mend(request, directory)
                request = prepare(request.resolved, directory, request.store, complete=True)
            if only_failed:
                failures = {record["unit_id"] for record in records.failed(directory)}
                request = request.resting_on(failures)
            if mend or only_failed:
                planned = _estimate(request)
            tasks, cases = len(request.plan.tasks), len(request.cases)
            click.echo(f"{cases} cases, {len(request.plan.units)} units, {tasks} tasks to run", err=True)
            with ExitStack() as stack:
                hooks = [hook.load()(directory) for hook in metadata.entry_points(group=AFTER_RUN)]
                publishers: list[Publisher] = [stack.enter_context(hook) for hook in hooks]

                def near_end() -> None:
                    for publisher in publishers:
                        publisher.get_ready()

                exit_status = execute(request, directory, launched, planned.document, cautions, near_end)
                for publisher in publishers:
                    publisher.publish()
    except KeyboardInterrupt:
        click.echo(f"interrupted; what is done is kept. Continue with: railvib resume {directory}", err=True)
        sys.exit(INTERRUPTED)
    except Exception as error:
        if not location.is_full(error):
            raise
        click.echo(
            f"{directory}: {error}; what was stored before is whole. "
            f"Make space, and continue with: railvib resume {directory}",
            err=True,
        )
        sys.exit(FAILED)
    if exit_status == FAILED:
        click.echo(f"some tasks failed; see: railvib status {directory}", err=True)
    sys.exit(exit_status)


def _mend(request: "Request", directory: Path) -> None:
    """Take back what is damaged of the results that are there."""
    from sweep.storage.verify import withdraw

    for each in withdraw(directory, request.plan.units.values()):
        click.echo(f"damaged: {each}; it is computed again", err=True)
    for hook in metadata.entry_points(group=VERIFY):
        hook.load()(directory, repair=True)


@contextmanager
def _stoppable() -> Iterator[None]:
    """Let the signal by which batch systems end a process stop it as cleanly as Ctrl-C does."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _estimate(request: "Request") -> "Estimate":
    """Return what a request takes; where there is something to do, by the rates of this machine."""
    from sweep.forecast import estimate

    if not request.plan.tasks:
        return estimate.Estimate()
    return estimate.estimate(request, _rates(request))


def _rates(request: "Request") -> "Rates":
    """Return the rates of this machine for all sorts of work that a request has."""
    from railvib.stages.fe_be_table import FeBeTable
    from sweep.forecast import pilot

    tasks = request.plan.tasks.values()
    return pilot.rates(any(isinstance(unit.stage, FeBeTable) for task in tasks for unit in task.units))


def _check_fits(request: "Request", planned: "Estimate", directory: Path, workers: int | None) -> None:
    import psutil

    from sweep.forecast import estimate

    if request.plan.tasks:
        memory = psutil.virtual_memory().total
        estimate.check(request, planned, _rates(request), directory, workers, memory)


def _check_plausibility(resolved: "Resolved", launched: "Launch") -> Callable[[], list[str]]:
    """Refuse what cannot be computed; what is returned waits for what is implausible."""
    from sweep import cautions

    cautions.check_plausibility(resolved)
    return launched.beside(cautions.cautions, resolved)


def _load(path: Path) -> "Resolved":
    from sweep import study

    with _cautions():
        return study.load(path)


@contextmanager
def _cautions() -> Iterator[None]:
    """Show what is implausible in a request as plain lines, each once."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PlausibilityWarning)
        yield
    for text in dict.fromkeys(str(each.message) for each in caught if each.category is PlausibilityWarning):
        click.echo(f"warning: {text}", err=True)


def _default_directory(resolved: "Resolved") -> Path:
    return _RUNS / resolved.study.study.name


def _latest(directory: Path) -> "Resolved":
    """Return the study of the latest run in a directory."""
    from sweep import study

    manifest = _manifest(directory)
    with _cautions():
        return study.resolve(manifest["study"])


def _manifest(directory: Path) -> dict[str, Any]:
    from sweep.storage.records import Run

    try:
        return Run.load(directory)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"{directory}: holds no run") from None
