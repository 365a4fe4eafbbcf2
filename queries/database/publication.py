"""What is made of a run's records: database, figures and report, and what is printed about them."""

from collections.abc import Sequence
from pathlib import Path

import duckdb
from rich.console import Console
from rich.text import Text

from queries.answers import compare, summary
from queries.answers.compare import Levels, Pair
from queries.database import connection as database
from queries.database.connection import Place, ResultsError
from queries.database.ingest import ingest
from queries.figures import figures
from queries.figures.crew import Crew
from queries.report import report

STORE = "transfer_functions.zarr"


def refresh(named: Path | str) -> None:
    """Bring the database of a run directory up to date with its records; a database file stays as it is."""
    if database.locate(named).directory is not None:
        ingest(named)


def publish(directory: Path, crew: Crew, begun: Path | None = None) -> None:
    """Publish database, figures and report of a run directory, and print the comparison.

    A report that shows the published snapshot is left alone; figures are redrawn only where results changed.

    Parameters
    ----------
    directory
        Of the run.
    crew
        Draws the figures while the report is made.
    begun
        What `queries.database.ingest.begin` has made.
    """
    place = database.locate(directory)
    ingest(directory, begun=begun)
    with database.connect(directory, bounded=True) as connection:
        now, before = database.snapshot(connection), report.shown(place.report)
        stale = before[1:] != now[1:] or not figures.drawn(connection, place.figures)
        drawing = crew.start(place.path, place.figures) if stale else None
        if before != now:
            report.write(connection, place.report)
        show(connection, place, Console())
        if drawing is not None:
            drawing()


def show(
    connection: duckdb.DuckDBPyConnection,
    place: Place,
    console: Console,
    approach: str | None = None,
    reference: str | None = None,
    by: Sequence[str] | None = None,
    contribution: str = "dynamic",
) -> None:
    """Print errors and costs, what is missing, and where everything lies.

    Parameters
    ----------
    connection, place
        Results, and where they lie.
    console
        Where to print.
    approach, reference
        A pair; every approach against the reference of the study if not given.
    by
        What to group errors by; case and receiver if not given.
    contribution
        dynamic, quasi-static or total.

    Raises
    ------
    ResultsError
        If the results have no such approach, or cannot be grouped so.
    """
    known = compare.approaches(connection)
    for name in (approach, reference):
        if name is not None and name not in known:
            raise ResultsError(f"{name}: no such approach in {place.named}, which has {', '.join(known)}")
    if approach is not None:
        pairs = [Pair.of_approaches(approach, reference or compare.reference(connection))]
    else:
        pairs = compare.pairs(connection)
    if by is None and approach is None and compare.case_count(connection) > compare.MANY_CASES:
        by = ("receiver",)
    tables = [compare.error_table(connection, pair, by, contribution) for pair in pairs]
    for table in (*tables, compare.cost_table(connection)):
        console.print()
        table.show(console)
    console.print()
    for sentence in summary.missing(connection):
        console.print(Text(sentence, style="bold"), soft_wrap=True)
    made = {"database": place.path, "figures": place.figures, "report": place.report}
    if place.directory is not None:
        made = {"store": place.directory / STORE, **made}
    for name, path in made.items():
        if path.exists():
            console.print(Text(f"{name:9} {path}"), soft_wrap=True)


def show_runs(
    named: Path,
    other: str,
    run_id: str | None,
    console: Console,
    by: Sequence[str] | None = None,
    contribution: str = "dynamic",
) -> None:
    """Print how far the levels of one run are from those of another, and what each cost.

    Parameters
    ----------
    named
        Run directory or database file.
    other
        Another one, or the id of a run in `named`.
    run_id
        Run of `named`; if not given, the newest of each case.
    console, by, contribution
        As for `show`.

    Raises
    ------
    ResultsError
        If there is no such run, or the runs share no case.
    """
    outside = Path(other).exists()
    if outside:
        refresh(other)
    with database.connect(named, other if outside else None) as connection:
        for each in (run_id, None if outside else other):
            found = "SELECT 1 FROM runs WHERE run_id = ?"
            if each is not None and connection.execute(found, [each]).fetchone() is None:
                runs = connection.execute("SELECT run_id FROM runs ORDER BY sequence").fetchall()
                raise ResultsError(
                    f"{each}: neither a path nor a run in {named}, which has "
                    f"{', '.join(row[0] for row in runs)}"
                )
        first = Levels(run_id or str(named), run_id=run_id)
        second = Levels(other, "other.") if outside else Levels(other, run_id=other)
        table = compare.error_table(connection, Pair.of_runs(first, second), by, contribution)
        if not table.rows:
            raise ResultsError(
                f"{first.title} and {second.title} share no case and approach of the same names"
            )
        for each_table in (table, compare.cost_table_of_runs(connection, first, second)):
            console.print()
            each_table.show(console)
