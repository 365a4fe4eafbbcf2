"""The sub-commands of `railvib` about results: ingest, sql, queries, compare, figures, report, export."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import click

_PATH = click.Path(path_type=Path)
_RESULTS = click.argument("named", type=_PATH, metavar="RESULTS")
_FORMAT = click.option(
    "--format", "form", type=click.Choice(["table", "csv", "parquet"]), default="table", show_default=True
)
_OUTPUT = click.option(
    "--output", type=click.Path(path_type=Path, dir_okay=False), help="File to write instead of printing."
)


class _WrongRequest(click.ClickException):
    """A request that cannot be met: one line on stderr."""

    exit_code = 2


def _one_line_errors(command: Callable[..., None]) -> Callable[..., None]:
    """Report a request that cannot be met as such, without a traceback."""

    @wraps(command)
    def checked(*given: Any, **named: Any) -> None:
        from queries.database.connection import ResultsError

        try:
            command(*given, **named)
        except ResultsError as error:
            raise _WrongRequest(str(error)) from error

    return checked


@click.command()
@click.argument("directories", nargs=-1, type=_PATH, metavar="[DIR]...")
@click.option(
    "--database",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="File for the results of several runs, hosts or versions. Default: results.duckdb in DIR.",
)
@click.option("--rebuild", is_flag=True, help="Make the database anew, from these directories alone.")
@_one_line_errors
def ingest(directories: tuple[Path, ...], file: Path | None, rebuild: bool) -> None:
    """Derive a database from the records and the store of each run directory DIR.

    With --database FILE, results of earlier directories stay in it; without a DIR those it has are brought
    up to date.
    """
    from queries.database.ingest import ingest as derive

    done = derive(directories, rebuild, file)
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
@_FORMAT
@_OUTPUT
@_one_line_errors
def sql(named: Path, statement: str, form: str, output: Path | None) -> None:
    """Ask RESULTS, a run directory or a database file, one question in SQL; nothing can be changed."""
    from queries.answers.sql import answer

    answer(named, statement, form, output)


@click.command()
@click.argument("name", required=False)
@click.argument("named", type=_PATH, metavar="[RESULTS]", required=False)
@click.option(
    "--set", "given", multiple=True, metavar="NAME=VALUE", help="Value of a parameter of the question."
)
@click.option(
    "--folder",
    type=_PATH,
    envvar="RAILVIB_QUERIES",
    help="Folder with .sql files of your own; also the environment variable RAILVIB_QUERIES.",
)
@_FORMAT
@_OUTPUT
@_one_line_errors
def queries(
    name: str | None,
    named: Path | None,
    given: tuple[str, ...],
    folder: Path | None,
    form: str,
    output: Path | None,
) -> None:
    """List questions that have a name, show the SQL of question NAME, or ask it of RESULTS."""
    from queries.answers import questions
    from queries.answers.sql import answer
    from queries.database import connection as database

    if name is None:
        for each in questions.questions(folder).values():
            click.echo(f"{click.style(each.name, bold=True)}\n    {each.sentence}")
        click.echo("\nrailvib queries NAME shows the SQL, railvib queries NAME RESULTS the answer.")
        return
    asked = questions.question(name, folder)
    if named is None:
        click.echo(f"-- {asked.sentence}")
        for key, parameter in asked.parameters.items():
            click.echo(f"-- ${key} = {parameter.default!r}: {parameter.meaning}")
        click.echo(asked.sql)
        return
    values = {}
    for setting in given:
        key, sign, value = setting.partition("=")
        if not sign:
            raise database.ResultsError(f"--set {setting}: must be NAME=VALUE")
        values[key] = value
    answer(named, asked.sql, form, output, asked.values(values))


@click.command()
@_RESULTS
@click.argument("approach", required=False)
@click.argument("reference", required=False)
@click.option(
    "--by", metavar="AXIS,...", help="What to group by, such as soil,speed,band. Default: case and receiver."
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
@_one_line_errors
def compare(
    named: Path,
    approach: str | None,
    reference: str | None,
    by: str | None,
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

    from queries.database import connection as database
    from queries.database import publication
    from queries.database.connection import ResultsError

    axes = tuple(part.strip() for part in by.split(",")) if by else None
    if other is not None and approach is not None:
        raise ResultsError("--with: two runs are compared approach by approach; name no APPROACH")
    if run_id is not None and other is None:
        raise ResultsError("--run: goes with --with OTHER")
    publication.refresh(named)
    if other is not None:
        publication.show_runs(named, other, run_id, Console(), axes, contribution)
        return
    with database.connect(named) as connection:
        publication.show(
            connection, database.locate(named), Console(), approach, reference, axes, contribution
        )


@click.command()
@_RESULTS
@click.option("--format", "form", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True)
@click.option(
    "--output", type=click.Path(path_type=Path, file_okay=False), help="Folder. Default: figures in DIR."
)
@_one_line_errors
def figures(named: Path, form: str, output: Path | None) -> None:
    """Draw the figures of RESULTS, a run directory or a database file, for print."""
    from queries.database import connection as database
    from queries.database import publication
    from queries.figures.crew import WORKERS, Crew

    publication.refresh(named)
    place = database.locate(named)
    with Crew(WORKERS) as crew:
        for figure in crew.start(place.path, output or place.figures, form, every=True)():
            click.echo(figure)


@click.command()
@_RESULTS
@click.option(
    "--output", type=click.Path(path_type=Path, dir_okay=False), help="File. Default: report.html in DIR."
)
@_one_line_errors
def report(named: Path, output: Path | None) -> None:
    """Write the report of RESULTS, a run directory or a database file: one page that needs no network."""
    from queries.database import connection as database
    from queries.database import publication
    from queries.report.report import write

    publication.refresh(named)
    with database.connect(named, bounded=True) as connection:
        click.echo(write(connection, output or database.locate(named).report))


@click.command()
@_RESULTS
@click.argument("folder", type=_PATH)
@_one_line_errors
def export(named: Path, folder: Path) -> None:
    """Write RESULTS, a run directory or a database file, as Parquet files into the new FOLDER."""
    from queries.answers.export import export as write
    from queries.database import publication

    publication.refresh(named)
    for written in write(named, folder):
        click.echo(folder / written)
