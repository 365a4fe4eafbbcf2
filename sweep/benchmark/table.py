"""The benchmark's tables as a person reads them."""

from collections.abc import Iterable, Mapping
from itertools import groupby
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from sweep.benchmark.figures import Figure

_SMALL, _LARGE = 1e-3, 1e5


def show(console: Console, document: Mapping[str, Any], figures: Iterable[Figure]) -> None:
    """Print where was measured, and a table per section."""
    console.print(
        f"{document['host_class']}, commit {document['commit']}, size {document['size']}; "
        f"load {document['load_before']:.1f} before, {document['load_after']:.1f} after",
        highlight=False,
    )
    rates = document["rates"]
    console.print(
        f"one core: {rates['operations'] / 1e9:.1f}e9 multiplications and additions, "
        f"{rates['divisions'] / 1e9:.2f}e9 divisions, {rates['roots'] / 1e9:.2f}e9 square roots per second",
        highlight=False,
    )
    for section, members in groupby(figures, key=lambda figure: figure.section):
        table = Table(title=section, title_justify="left", box=box.SIMPLE_HEAD)
        for heading in ("what", "case", "quantity"):
            table.add_column(heading)
        for heading in ("median", "quartiles", "unit", "aim"):
            table.add_column(heading, justify="right", no_wrap=True)
        for figure in members:
            table.add_row(figure.item, figure.case, figure.quantity, *_values(figure))
        console.print(table)


def _values(figure: Figure) -> tuple[str, str, str, str]:
    spread = f"{number(figure.quantile(0.25))} – {number(figure.quantile(0.75))}"
    aim = ""
    if figure.holds is not None:
        relation, value = ("≥", figure.at_least) if figure.at_least is not None else ("≤", figure.at_most)
        aim = f"{relation} {number(value or 0.0)} {'holds' if figure.holds else '[bold red]missed[/]'}"
    return (
        number(figure.median),
        spread if len(figure.samples) > 1 else "",
        "" if figure.unit == "1" else figure.unit,
        aim,
    )


def number(value: float) -> str:
    """Return a number to three digits.

    >>> number(0.00012345), number(12.345), number(1234.5), number(123456.0)
    ('1.23e-04', '12.3', '1,234', '1.23e+05')
    """
    if value != 0.0 and (abs(value) < _SMALL or abs(value) >= _LARGE):
        return f"{value:.2e}"
    return f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
