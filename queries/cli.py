"""The sub-commands of `railvib` about results: ingest, sql, compare, report."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import click

_DIRECTORY = click.argument("directory", type=click.Path(path_type=Path), metavar="DIR")
_CONTRIBUTION = click.option(
    "--contribution",
    type=click.Choice(["dynamic", "quasi-static", "total"]),
    default="dynamic",
    show_default=True,
    help="Part of the response to compare.",
)


class _WrongRequest(click.ClickException):
    """A request that cannot be met: one line on stderr."""

    exit_code = 2


def _one_line_errors(command: Callable[..., None]) -> Callable[..., None]:
    """Report a request that cannot be met as such, without a traceback."""

    @wraps(command)
    def checked(*given: Any, **named: Any) -> None:
        from queries.database import ResultsError

        try:
            command(*given, **named)
        except ResultsError as error:
            raise _WrongRequest(str(error)) from error

    return checked


@click.command()
@_DIRECTORY
@click.option("--rebuild", is_flag=True, help="Make the database anew even if nothing changed.")
@_one_line_errors
def ingest(directory: Path, rebuild: bool) -> None:
    """Derive results.duckdb of the run directory DIR from its records and its store."""
    from queries.ingest import ingest as derive

    done = derive(directory, rebuild)
    click.echo(f"{done.path}: {'made anew' if done.changed else 'up to date'}")
    for unit in done.unreadable:
        click.echo(
            f"warning: the arrays of {unit} cannot be read; `railvib resume` computes them again", err=True
        )


@click.command()
@_DIRECTORY
@click.argument("statement", metavar="SQL")
@click.option(
    "--format", "form", type=click.Choice(["table", "csv", "parquet"]), default="table", show_default=True
)
@click.option(
    "--output", type=click.Path(path_type=Path, dir_okay=False), help="File to write instead of printing."
)
@_one_line_errors
def sql(directory: Path, statement: str, form: str, output: Path | None) -> None:
    """Ask the results of the run directory DIR one question in SQL; nothing can be changed."""
    from queries.sql import answer

    answer(directory, statement, form, output)


@click.command()
@_DIRECTORY
@click.argument("approach", required=False)
@click.argument("reference", required=False)
@_CONTRIBUTION
@_one_line_errors
def compare(directory: Path, approach: str | None, reference: str | None, contribution: str) -> None:
    """Show the error of each approach against the reference, and what it costs.

    With APPROACH and REFERENCE only that pair. Errors are the level of the approach minus that of the
    reference.
    """
    from rich.console import Console

    from queries import compare as comparison
    from queries import database, publication
    from queries.ingest import ingest as derive

    derive(directory)
    with database.connect(directory) as connection:
        known = comparison.approaches(connection)
        for name in (approach, reference):
            if name is not None and name not in known:
                raise database.ResultsError(
                    f"{name}: no such approach in {directory}, which has {', '.join(known)}"
                )
        pair = None if approach is None else (approach, reference or comparison.reference(connection))
        publication.show(connection, directory, Console(), pair, contribution)


@click.command()
@_DIRECTORY
@_one_line_errors
def report(directory: Path) -> None:
    """Draw the figures of the run directory DIR anew and write its report.html."""
    from queries import database, publication
    from queries.ingest import ingest as derive

    derive(directory)
    with database.connect(directory) as connection:
        click.echo(publication.publish_report(connection, directory))
