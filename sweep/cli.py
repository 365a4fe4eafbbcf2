"""The engine's sub-commands: plan, run, status and resume.

Each imports what it needs when it runs, so that `--help` and finished runs stay quick.
"""

import gc
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from railvib.errors import InputError, PlausibilityWarning, printable

if TYPE_CHECKING:
    from sweep.study import Resolved
    from sweep.workers.launch import Launch

STUDY = click.Path(dir_okay=False, path_type=Path)
DIRECTORY = click.Path(file_okay=False, path_type=Path)
_RUNS = Path("runs")
_PLANNED_AT_ONCE = 5000
"""Number of cases above which planning announces how long it will take."""
_PLANNING_S = 1.2e-3
"""Planning time per case; measured with two approaches."""

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
            "--wait",
            type=click.FloatRange(min=0.0, min_open=True),
            metavar="MINUTES",
            help="How long to wait for workers of --scheduler or --cluster when there are none. Default: 60; "
            "without limit in the queue of a batch system.",
        ),
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
    """Show what running STUDY takes: cases, tasks, results present, bytes, memory, processor time.

    Processor time and memory are for this machine, from a pilot run of a few seconds that is kept. A study
    that cannot fit is refused.
    """
    from sweep import driver
    from sweep.forecast import estimate
    from sweep.workers.launch import Launch

    resolved = _load(study)
    directory = out or _default_directory(resolved)
    prepared = driver.plan(resolved, directory, store, Launch(workers=0))
    for text in prepared.cautions():
        _say(f"warning: {text}", err=True)
    workers = Launch().local_processes
    click.echo(estimate.describe(prepared.request, prepared.planned, directory, workers))
    driver.check_fits(prepared, workers)


@click.command()
@click.argument("study", type=STUDY)
@click.option("--out", type=DIRECTORY, help="Output directory. Default: runs/<study>.")
@STORED
@computing
def run(study: Path, out: Path | None, store: str | None, **launch: Any) -> None:
    """Compute what is missing of STUDY, and publish the results."""
    with _collect_garbage_later():
        launched = _launch(launch, out or _RUNS / study.stem)
        from sweep import driver

        resolved = _load(study)
        prepared = driver.plan(resolved, out or _default_directory(resolved), store, launched)
        driver.check_fits(prepared, launched.local_processes)
    sys.exit(driver.drive(prepared, launched))


@click.command()
@click.argument("directory", type=DIRECTORY)
@click.option("--failed", is_flag=True, help="Only what has failed, and what waited for it.")
@click.option("--study", type=STUDY, help="The study, where the manifest of the run is gone or damaged.")
@STORED
@computing
def resume(directory: Path, failed: bool, study: Path | None, store: str | None, **launch: Any) -> None:
    """Compute what is missing, damaged or failed of the latest run in DIRECTORY."""
    with _collect_garbage_later():
        launched = _launch(launch, directory)
        from sweep import driver

        resolved = _latest(directory) if study is None else _study_of(directory, study)
        prepared = driver.plan(resolved, directory, store, launched)
        driver.check_fits(prepared, launched.local_processes)
    sys.exit(driver.drive(prepared, launched, mend=True, only_failed=failed))


@click.command()
@click.argument("directory", type=DIRECTORY)
@click.option("--verify", is_flag=True, help="Read all results, and compare them with their checksums.")
def status(directory: Path, verify: bool) -> None:
    """Show how far the latest run in DIRECTORY is, and what failed."""
    from sweep import status as state
    from sweep.workers import leftovers

    manifest = _manifest(directory)
    for line in state.describe(directory, manifest):
        _say(line)
    if not state.alive(directory):
        leftovers.discard_keys(directory)
    faults = _faults(directory) if verify else []
    if verify:
        click.echo(f"damaged   {len(faults)}")
    for fault in faults:
        _say(f"  {fault}")
    if (faults or manifest["exit_status"] != 0) and not state.alive(directory):
        _say(f"continue with: railvib resume {directory}")
    sys.exit(1 if faults else 0)


def _faults(directory: Path) -> list[str]:
    """Return one line for each damaged result that the latest run in a directory rests on."""
    from sweep import hooks
    from sweep.request import prepare
    from sweep.storage.verify import find_damage

    needed = prepare(_latest(directory), directory).plan.units.values()
    faults = [str(damage) for damage in find_damage(directory, needed)]
    if _manifest(directory)["finished"] is None:  # nothing has been published yet
        return faults
    return faults + hooks.published_faults(directory)


@contextmanager
def _collect_garbage_later() -> Iterator[None]:
    """Switch off garbage collection meanwhile: it takes a fifth of the time of a run's imports."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _launch(launch: Mapping[str, Any], directory: Path) -> "Launch":
    """Return the launch settings; for a first run, start to prepare workers while it is planned."""
    from sweep.storage import records
    from sweep.workers.launch import STAGES, Launch

    launched = Launch(**launch)
    if not (directory / records.MANIFEST).exists():
        launched.get_ready(STAGES)
    return launched


def _load(path: Path) -> "Resolved":
    from sweep import study

    with _cautions():
        resolved = study.load(path)
    combinations = resolved.study.sweep.combinations
    if combinations > _PLANNED_AT_ONCE:
        _say(f"planning {combinations} cases, some {combinations * _PLANNING_S:.2g} s", err=True)
    return resolved


@contextmanager
def _cautions() -> Iterator[None]:
    """Print each plausibility warning once, as a plain line."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PlausibilityWarning)
        yield
    messages = [str(warning.message) for warning in caught if warning.category is PlausibilityWarning]
    for text in dict.fromkeys(messages):
        _say(f"warning: {text}", err=True)


def _say(text: str, err: bool = False) -> None:
    """Print a line that may contain text from files."""
    click.echo(printable(text), err=err)


def _default_directory(resolved: "Resolved") -> Path:
    return _RUNS / resolved.study.study.name


def _latest(directory: Path) -> "Resolved":
    """Return the study of the latest run in a directory."""
    from sweep import study

    manifest = _manifest(directory)
    with _cautions():
        return study.resolve(manifest["study"])


def _study_of(directory: Path, path: Path) -> "Resolved":
    """Return a study for a directory of results whose manifest is gone.

    Raises
    ------
    InputError
        If the directory holds no results, or its manifest is there and names another study.
    """
    from sweep.storage import records

    resolved = _load(path)
    if not (directory / records.RECORDS).is_dir():
        raise InputError(f"{directory}: holds no run")
    with suppress(FileNotFoundError):
        run, given = records.Run.load(directory)["study_name"], resolved.study.study.name
        if run != given:
            raise InputError(f"--study = {str(path)!r}: is {given!r}; the run is of {run!r}")
    return resolved


def _manifest(directory: Path) -> dict[str, Any]:
    from sweep.storage import records

    try:
        return records.Run.load(directory)
    except (FileNotFoundError, NotADirectoryError):
        if (directory / records.RECORDS).is_dir():
            raise InputError(
                f"{directory}: its manifests are gone or damaged; go on with: "
                f"railvib resume {directory} --study FILE"
            ) from None
        raise InputError(f"{directory}: holds no run") from None
