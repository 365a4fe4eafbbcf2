"""Publication of a run: database, figures and report, and the comparison that is printed."""

from collections.abc import Sequence
from pathlib import Path

import duckdb
from rich.console import Console
from rich.text import Text

from queries import answers
from queries.answers import Levels, Pair
from queries.database import Place, ResultsError, connect, ingest, locate, snapshot
from queries.figures import FigureProcesses
from queries.figures.catalogue import are_drawn
from queries.report import shown_snapshot, write_report

_STORE = "transfer_functions.zarr"


def refresh(named: Path | str) -> None:
    """Bring the database of a run directory up to date with its records; leave other files alone."""
    if locate(named).directory is not None:
        ingest(named)


def publish(directory: Path, processes: FigureProcesses, begun: Path | None = None) -> None:
    """Publish database, figures and report of a run directory, and print the comparison.

    A report that shows the published snapshot is left alone; figures are redrawn only where results changed.

    Parameters
    ----------
    directory
        Of the run.
    processes
        Draw the figures while the report is made.
    begun
        What `queries.database.begin` has made.
    """
    place = locate(directory)
    ingest(directory, begun=begun)
    with connect(directory, bounded=True) as connection:
        now, before = snapshot(connection), shown_snapshot(place.report)
        stale = before[1:] != now[1:] or not are_drawn(connection, place.figures)
        finish = processes.start(connection, place.path, place.figures) if stale else None
        if before != now:
            write_report(connection, place.report)
        show(connection, place, Console())
        if finish is not None:
            finish()


def show(
    connection: duckdb.DuckDBPyConnection,
    place: Place,
    console: Console,
    pair: tuple[str | None, str | None] = (None, None),
    by: Sequence[str] | None = None,
    contribution: str = "dynamic",
    receivers: str | None = None,
) -> None:
    """Print errors and costs, what is missing, and the paths of all products.

    Parameters
    ----------
    connection, place
        Results, and where they lie.
    console
        Where to print.
    pair
        An approach and what it is compared with, by default the reference of the study; without an approach
        every one.
    by
        What to group errors by; case and receiver if not given.
    contribution
        dynamic, quasi-static or total.
    receivers
        What may be averaged, see `queries.answers.PLACES`.

    Raises
    ------
    ResultsError
        If the results have no such approach, or cannot be grouped so.
    """
    known = answers.requested_approaches(connection)
    for name in pair:
        if name is not None and name not in known:
            raise ResultsError(f"{name}: no such approach in {place.named}, which has {', '.join(known)}")
    approach, against = pair
    if approach is not None:
        pairs = [Pair.of_approaches(approach, against or answers.reference(connection))]
    else:
        pairs = answers.pairs(connection)
    if by is None and approach is None and answers.case_count(connection) > answers.MANY_CASES:
        by = ("receiver",)
    tables = [answers.error_table(connection, pair, by, contribution, receivers) for pair in pairs]
    for table in (*tables, answers.cost_table(connection)):
        console.print()
        table.show(console)
    console.print()
    for sentence in (*answers.missing_notes(connection), *answers.extrapolation_notes(connection)):
        console.print(Text(sentence, style="bold"), soft_wrap=True)
    products = {"database": place.path, "figures": place.figures, "report": place.report}
    if place.directory is not None:
        products = {"store": place.directory / _STORE, **products}
    for name, path in products.items():
        if path.exists():
            console.print(Text(f"{name:9} {path}"), soft_wrap=True)


def show_runs(
    named: Path,
    other: str,
    run_id: str | None,
    console: Console,
    by: Sequence[str] | None = None,
    contribution: str = "dynamic",
    receivers: str | None = None,
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
    console, by, contribution, receivers
        As for `show`.

    Raises
    ------
    ResultsError
        If there is no such run, or the runs share no case.
    """
    outside = Path(other).exists()
    if outside:
        refresh(other)
    with connect(named, other if outside else None) as connection:
        for name in (run_id, None if outside else other):
            if name is not None:
                _check_run(connection, name, named)
        first = Levels(run_id or str(named), run_id=run_id)
        second = Levels(other, "other.") if outside else Levels(other, run_id=other)
        pair = Pair.of_runs(first, second)
        table = answers.error_table(connection, pair, by, contribution, receivers)
        if not table.rows:
            raise ResultsError(
                f"{first.title} and {second.title} share no case and approach of the same names"
            )
        for comparison in (table, answers.cost_table_of_runs(connection, first, second)):
            console.print()
            comparison.show(console)


def _check_run(connection: duckdb.DuckDBPyConnection, run_id: str, named: Path) -> None:
    rows = connection.execute("SELECT run_id FROM runs ORDER BY sequence").fetchall()
    known = [row[0] for row in rows]
    if run_id not in known:
        raise ResultsError(f"{run_id}: neither a path nor a run in {named}, which has {', '.join(known)}")
