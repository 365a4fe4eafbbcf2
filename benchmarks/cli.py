"""The program that measures: ``python -m benchmarks``."""

from pathlib import Path

import click

SECTIONS = ("kernel", "transfer", "study", "growth", "extras")


@click.command()
@click.option(
    "--only",
    metavar="SECTIONS",
    default=",".join(SECTIONS),
    show_default=True,
    help="Sections, separated by commas.",
)
@click.option(
    "--size",
    type=click.Choice(["full", "quick"]),
    default="full",
    show_default=True,
    help="full takes about a quarter of an hour, quick about three minutes.",
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("runs/benchmarks"),
    show_default=True,
    help="Folder for the JSON file of this run, and the database of all runs in it.",
)
def benchmark(only: str, size: str, out: Path) -> None:
    """Measure railvib on this machine, against other ways and against the limit of the processor.

    Let nothing else run meanwhile.
    """
    names = [name.strip() for name in only.split(",")]
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        raise click.UsageError(f"--only = {unknown[0]!r}: must be of {', '.join(SECTIONS)}")

    from rich.console import Console
    from rich.markup import escape

    from benchmarks import database, document, table
    from benchmarks.figures import Figure
    from benchmarks.sizes import SIZES

    console = Console(stderr=True)

    def report(figure: Figure) -> None:
        text = f"{figure.section}: {figure.item}, {figure.case}, {figure.quantity}"
        console.print(f"{escape(text)} {table.number(figure.median)} {figure.unit}", highlight=False)

    ordered = [name for name in SECTIONS if name in names]
    content, figures = document.measure(SIZES[size], ordered, report)
    file = document.write(content, out)
    table.show(Console(), content, figures)
    click.echo(f"database  {database.rebuild(out)}")
    click.echo(f"figures   {file}")
