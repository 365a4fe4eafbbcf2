"""What is made of a run's records: database, figures and report, and what is printed about them."""

from pathlib import Path
from typing import TYPE_CHECKING

import duckdb

from queries import compare, database, summary
from queries.database import DATABASE
from queries.ingest import ingest

if TYPE_CHECKING:
    from rich.console import Console

REPORT, FIGURES, STORE = "report.html", "figures", "transfer_functions.zarr"


def after_run(directory: Path) -> None:
    """Publish database, figures and report of a run directory, and print the comparison.

    A report that shows the published snapshot is left alone; figures are redrawn only where results changed.
    """
    from rich.console import Console

    from queries.report import shown

    console = Console()
    ingest(directory)
    with database.connect(directory) as connection:
        snapshot = list(connection.execute("SELECT fingerprint, results FROM snapshot").fetchone() or ())
        before = shown(directory)
        if before != snapshot:
            publish_report(connection, directory, redraw=before[1:] != snapshot[1:])
        show(connection, directory, console)


def publish_report(connection: duckdb.DuckDBPyConnection, directory: Path, redraw: bool = True) -> Path:
    """Draw the figures of a run, unless they may stay, write its report, and return its path."""
    from queries import figures
    from queries.report import report

    pictures = None if redraw else figures.drawn(connection, directory)
    return report(connection, directory, pictures or figures.publish(connection, directory))


def show(
    connection: duckdb.DuckDBPyConnection,
    directory: Path,
    console: "Console",
    pair: tuple[str, str] | None = None,
    contribution: str = "dynamic",
) -> None:
    """Print errors and costs, what is missing, and where everything lies.

    Parameters
    ----------
    connection, directory
        Results and output directory of the run.
    console
        Where to print.
    pair
        Approach and reference; every approach against the reference of the study if not given.
    contribution
        dynamic, quasi-static or total.
    """
    from rich.text import Text

    if pair is None:
        tables = compare.tables(connection, contribution)
    else:
        tables = [
            compare.error_table(connection, *pair, contribution=contribution),
            compare.cost_table(connection),
        ]
    for table in tables:
        console.print()
        table.show(console)
    console.print()
    for sentence in summary.missing(connection):
        console.print(Text(sentence, style="bold"), soft_wrap=True)
    for name, place in (("store", STORE), ("database", DATABASE), ("figures", FIGURES), ("report", REPORT)):
        if (directory / place).exists():
            console.print(Text(f"{name:9} {directory / place}"), soft_wrap=True)
