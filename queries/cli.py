"""The sub-commands of `railvib` about results: ingest, sql, queries, compare, figures, report, export."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import click

from queries.refusal import Refusal, refusing

_PATH = click.Path(path_type=Path)
_RESULTS = click.argument("named", type=_PATH, metavar="RESULTS")
_POSITIVE = click.FloatRange(min=0, min_open=True)


def _asking(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of commands that answer a question in SQL."""
    for option in (
        click.option(
            "--print-limit", type=_POSITIVE, default=100.0, metavar="MB", help="Longest answer printed."
        ),
        click.option("--memory-limit", type=_POSITIVE, default=2000.0, metavar="MB", help="Largest memory."),
        click.option("--time-limit", type=_POSITIVE, default=60.0, metavar="SECONDS", help="Longest time."),
        click.option("--output", type=click.Path(path_type=Path), help="File to write instead of printing."),
        click.option(
            "--format",
            "form",
            type=click.Choice(["table", "csv", "parquet"]),
            default="table",
            show_default=True,
        ),
    ):
        command = option(command)
    return command


def _in_one_line(command: Callable[..., None]) -> Callable[..., None]:
    """Report a request that cannot be met in one line, without a traceback."""

    @wraps(command)
    def refusable(*arguments: Any, **options: Any) -> None:
        with refusing():
            command(*arguments, **options)

    return refusable


@click.command()
@click.argument("directories", nargs=-1, type=_PATH, metavar="[DIR]...")
@click.option(
    "--database",
    "file",
    type=_PATH,
    help="File for the results of several runs, hosts or versions. Default: results.duckdb in DIR.",
)
@click.option("--rebuild", is_flag=True, help="Make the database anew, from these directories alone.")
@_in_one_line
def ingest(directories: tuple[Path, ...], file: Path | None, rebuild: bool) -> None:
    """Derive a database from the records and the store of each run directory DIR.

    With --database FILE, results of earlier directories stay in it; without a DIR those it has are brought
    up to date.
    """
    from queries import database

    done = database.ingest(directories, rebuild, file)
    if done.backup is not None:
        click.echo(f"{done.backup}: copy of the file as it was, of an earlier form")
    click.echo(f"{done.path}: {'written' if done.changed else 'up to date'}")
    for directory, unit in done.unreadable:
        click.echo(
            f"warning: the arrays of {unit} cannot be read; `railvib resume {directory}` computes them again",
            err=True,
        )


@click.command()
@_RESULTS
@click.argument("statement", metavar="SQL")
@_asking
@_in_one_line
def sql(named: Path, statement: str, form: str, output: Path | None, **limits: float) -> None:
    """Ask RESULTS, a run directory or a database file, one question in SQL; nothing can be changed."""
    from queries import answers

    answers.answer(named, statement, form, output, (), answers.Limits(*_limit_values(limits)))


def _limit_values(limits: dict[str, float]) -> tuple[float, float, float]:
    return limits["time_limit"], limits["memory_limit"], limits["print_limit"]


@click.command()
@click.argument("name", required=False)
@click.argument("named", type=_PATH, metavar="[RESULTS]", required=False)
@click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE", help="Value of a parameter of the question."
)
@click.option(
    "--folder",
    type=_PATH,
    envvar="RAILVIB_QUERIES",
    help="Folder with .sql files of your own; also the environment variable RAILVIB_QUERIES.",
)
@_asking
@_in_one_line
def queries(
    name: str | None,
    named: Path | None,
    settings: tuple[str, ...],
    folder: Path | None,
    form: str,
    output: Path | None,
    **limits: float,
) -> None:
    """List questions that have a name, show the SQL of question NAME, or ask it of RESULTS."""
    from queries import answers

    if name is None:
        for question in answers.questions(folder).values():
            click.echo(f"{click.style(question.name, bold=True)}\n    {question.sentence}")
        click.echo("\nrailvib queries NAME shows the SQL, railvib queries NAME RESULTS the answer.")
        return
    question = answers.question(name, folder)
    if named is None:
        click.echo(f"-- {question.sentence}")
        for key, parameter in question.parameters.items():
            click.echo(f"-- ${key} = {parameter.default!r}: {parameter.meaning}")
        click.echo(question.sql)
        return
    values = {}
    for setting in settings:
        key, sign, value = setting.partition("=")
        if not sign:
            raise Refusal(f"--set {setting}: must be NAME=VALUE")
        values[key] = value
    parameters = question.values(values)
    answers.answer(named, question.sql, form, output, parameters, answers.Limits(*_limit_values(limits)))


@click.command()
@_RESULTS
@click.argument("approach", required=False)
@click.argument("reference", required=False)
@click.option(
    "--by", metavar="AXIS,...", help="What to group by, such as soil,speed,band. Default: case and receiver."
)
@click.option(
    "--receivers",
    type=click.Choice(["ground", "rail", "force", "velocity"]),
    help="What to average where receivers do not stand apart: ground velocity (the default), rail velocity, "
    "wheel-rail force, or velocity of rail and ground together.",
)
@click.option(
    "--contribution",
    type=click.Choice(["dynamic", "quasi-static", "total"]),
    default="dynamic",
    show_default=True,
    help="Part of the response to compare.",
)
@click.option(
    "--with",
    "other",
    metavar="OTHER",
    help="Compare with another run instead: a run directory, a database file, or the id of a run in RESULTS.",
)
@click.option(
    "--run", "run_id", help="Run of RESULTS to compare with OTHER. Default: the newest of each case."
)
@_in_one_line
def compare(
    named: Path,
    approach: str | None,
    reference: str | None,
    by: str | None,
    receivers: str | None,
    contribution: str,
    other: str | None,
    run_id: str | None,
) -> None:
    """Show the error of each approach against the reference, and what it costs.

    RESULTS is a run directory or a database file. With APPROACH and REFERENCE only that pair is shown;
    errors are the level of the approach minus that of the reference. With --with OTHER they are the levels of
    RESULTS minus those of OTHER.
    """
    from rich.console import Console

    from queries import publication
    from queries.database import connect, locate

    axes = tuple(part.strip() for part in by.split(",")) if by else None
    if other is not None and approach is not None:
        raise Refusal("--with: two runs are compared approach by approach; name no APPROACH")
    if run_id is not None and other is None:
        raise Refusal("--run: goes with --with OTHER")
    publication.refresh(named)
    if other is not None:
        publication.show_runs(named, other, run_id, Console(), axes, contribution, receivers)
        return
    with connect(named) as connection:
        pair = (approach, reference)
        publication.show(connection, locate(named), Console(), pair, axes, contribution, receivers)


@click.command()
@_RESULTS
@click.option("--format", "form", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True)
@click.option("--output", type=_PATH, help="Folder. Default: figures in DIR.")
@_in_one_line
def figures(named: Path, form: str, output: Path | None) -> None:
    """Draw the figures of RESULTS, a run directory or a database file, for print."""
    from queries import publication
    from queries.database import connect, locate
    from queries.figures import WORKERS, FigureProcesses

    publication.refresh(named)
    place = locate(named)
    with FigureProcesses(WORKERS) as processes, connect(named, bounded=True) as connection:
        finish = processes.start(connection, place.path, output or place.figures, form, every=True)
        for figure in finish():
            click.echo(figure)


@click.command()
@_RESULTS
@click.option("--output", type=_PATH, help="File. Default: report.html in DIR.")
@_in_one_line
def report(named: Path, output: Path | None) -> None:
    """Write the report of RESULTS, a run directory or a database file: one page that needs no network."""
    from queries import publication
    from queries.database import connect, locate
    from queries.report import write_report

    publication.refresh(named)
    with connect(named, bounded=True) as connection:
        click.echo(write_report(connection, output or locate(named).report))


@click.command()
@_RESULTS
@click.argument("folder", type=_PATH)
@_in_one_line
def export(named: Path, folder: Path) -> None:
    """Write RESULTS, a run directory or a database file, as Parquet files into the new FOLDER."""
    from queries import answers, publication

    publication.refresh(named)
    for file in answers.export(named, folder):
        click.echo(folder / file)
