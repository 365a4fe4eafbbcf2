"""The engine's sub-commands: plan, run, status and resume.

What they need is imported when they run, so that asking for help, or for what is done already, stays quick.
"""

import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from railvib.errors import InputError, PlausibilityWarning

if TYPE_CHECKING:
    from sweep.run import Request
    from sweep.study import Resolved

AFTER_RUN = "railvib.after_run"
STUDY = click.Path(dir_okay=False, path_type=Path)
DIRECTORY = click.Path(file_okay=False, path_type=Path)

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
            "--scheduler", metavar="ADDRESS", help="Use the workers of a Dask scheduler, tcp://HOST:PORT."
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
    """Show what running STUDY takes: cases, tasks, what is there already, bytes and memory."""
    from sweep import estimate
    from sweep.run import prepare

    resolved = _load(study)
    directory = out or _default_directory(resolved)
    request = prepare(resolved, directory, store)
    _check_plausibility(request)
    click.echo(estimate.describe(request, directory))


@click.command()
@click.argument("study", type=STUDY)
@click.option("--out", type=DIRECTORY, help="Output directory. Default: runs/<study>.")
@STORED
@computing
def run(study: Path, out: Path | None, store: str | None, **launch: Any) -> None:
    """Compute what is missing of STUDY, and publish the results."""
    from sweep.run import prepare

    resolved = _load(study)
    directory = out or _default_directory(resolved)
    _run(prepare(resolved, directory, store), directory, launch)


@click.command()
@click.argument("directory", type=DIRECTORY)
@STORED
@computing
def resume(directory: Path, store: str | None, **launch: Any) -> None:
    """Compute what is missing or has failed of the latest run in DIRECTORY."""
    from sweep import study
    from sweep.run import prepare

    manifest = _manifest(directory)
    with _cautions():
        resolved = study.resolve(manifest["study"])
    _run(prepare(resolved, directory, store), directory, launch)


@click.command()
@click.argument("directory", type=DIRECTORY)
def status(directory: Path) -> None:
    """Show how far the latest run in DIRECTORY is, and what failed."""
    from sweep import records

    manifest = _manifest(directory)
    present = records.present(directory)
    needed = {
        unit["unit_id"] for case in manifest["cases"] for units in case["units"].values() for unit in units
    }
    complete = [
        case
        for case in manifest["cases"]
        if all(unit["unit_id"] in present for units in case["units"].values() for unit in units)
    ]
    ended = manifest["finished"] or "not finished"
    click.echo(f"study     {manifest['study_name']}, run {manifest['run_id']} on {manifest['host']}")
    click.echo(f"started   {manifest['started']}, {ended}, exit status {manifest['exit_status']}")
    click.echo(f"cases     {len(complete)} of {len(manifest['cases'])} complete")
    click.echo(f"units     {len(needed & present)} of {len(needed)} done")
    failures = [record for record in records.failed(directory) if record["unit_id"] in needed]
    click.echo(f"failures  {len(failures)}")
    for record in failures:
        click.echo(f"  {record['kind']}/{record['unit_id']}: {record['traceback'].strip().splitlines()[-1]}")
    if needed - present:
        click.echo(f"continue with: railvib resume {directory}")


def _run(request: "Request", directory: Path, launch: Mapping[str, Any]) -> None:
    """Compute, publish, and leave with the exit status."""
    from sweep.launch import Launch
    from sweep.run import FAILED, INTERRUPTED, execute

    if request.plan.tasks:
        _check_plausibility(request)
    tasks, cases = len(request.plan.tasks), len(request.cases)
    click.echo(f"{cases} cases, {len(request.plan.units)} units, {tasks} tasks to run", err=True)
    try:
        exit_status = execute(request, directory, Launch(**launch))
    except KeyboardInterrupt:
        click.echo(f"interrupted; what is done is kept. Continue with: railvib resume {directory}", err=True)
        sys.exit(INTERRUPTED)
    for hook in metadata.entry_points(group=AFTER_RUN):
        hook.load()(directory)
    if exit_status == FAILED:
        click.echo(f"some tasks failed; see: railvib status {directory}", err=True)
    sys.exit(exit_status)


def _check_plausibility(request: "Request") -> None:
    from sweep import units

    with _cautions():
        units.check_plausibility(request.resolved)


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
    return Path("runs") / resolved.study.study.name


def _manifest(directory: Path) -> dict[str, Any]:
    from sweep.records import Run

    try:
        return Run.load(directory)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"{directory}: holds no run") from None
