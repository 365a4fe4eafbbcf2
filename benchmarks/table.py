"""Tables of the benchmark for a terminal, or in Markdown for a file."""

from collections.abc import Iterable, Mapping
from itertools import groupby
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from benchmarks.figures import Figure

_SMALL, _LARGE = 1e-3, 1e5
_SUMMARISED, _MOST_CASES = "transfer", 5
"""In this section more cases of one quantity than these share a row."""


def show(console: Console, document: Mapping[str, Any], figures: Iterable[Figure]) -> None:
    """Print the machine and the rates of its cores, and a table per section."""
    if not console.is_terminal:
        console.width = 200
    console.print(
        f"{document['host_class']}, commit {document['commit']}, size {document['size']}; "
        f"load {document['load_before']:.1f} before, {document['load_after']:.1f} after.",
        highlight=False,
    )
    rates = document["rates"]
    console.print(
        f"One core: {rates['operations'] / 1e9:.1f}e9 multiplications and additions, "
        f"{rates['divisions'] / 1e9:.2f}e9 divisions, {rates['roots'] / 1e9:.2f}e9 square roots per second.",
        highlight=False,
    )
    for section, members in groupby(figures, key=lambda figure: figure.section):
        style = box.SIMPLE_HEAD if console.is_terminal else box.MARKDOWN
        table = Table(title=f"\n{section}", title_justify="left", box=style)
        for heading in ("what", "case", "quantity"):
            table.add_column(heading)
        for heading in ("median", "quartiles, or least – most", "unit", "target"):
            table.add_column(heading, justify="right", no_wrap=True)
        rows: dict[tuple[str, str], list[Figure]] = {}
        for figure in members:
            rows.setdefault((figure.item, figure.quantity), []).append(figure)
        for row in rows.values():
            if section == _SUMMARISED and len(row) > _MOST_CASES:
                table.add_row(*_summary(row))
            else:
                for figure in row:
                    table.add_row(*_single(figure))
        console.print(table)


def _single(figure: Figure) -> tuple[str, ...]:
    """Return the row of one figure: its median and quartiles."""
    spread = f"{number(figure.quantile(0.25))} – {number(figure.quantile(0.75))}"
    verdict = "" if figure.holds is None else " holds" if figure.holds else " missed"
    return (
        figure.item,
        figure.case,
        figure.quantity,
        number(figure.median),
        spread if len(figure.samples) > 1 else "",
        _unit(figure),
        _target(figure) + verdict,
    )


def _summary(figures: list[Figure]) -> tuple[str, ...]:
    """Return the row of one quantity in many cases: the median of all, the smallest and the largest."""
    first = figures[0]
    medians = [figure.median for figure in figures]
    holds = sum(figure.holds is True for figure in figures)
    return (
        first.item,
        f"{len(figures)} cases",
        first.quantity,
        number(float(np.median(medians))),
        f"{number(min(medians))} – {number(max(medians))}",
        _unit(first),
        "" if first.holds is None else f"{_target(first)} holds in {holds}",
    )


def _unit(figure: Figure) -> str:
    return "" if figure.unit == "1" else figure.unit


def _target(figure: Figure) -> str:
    if figure.at_least is not None:
        return f"≥ {number(figure.at_least)}"
    return "" if figure.at_most is None else f"≤ {number(figure.at_most)}"


def number(value: float) -> str:
    """Return a number to three digits.

    >>> number(0.00012345), number(12.345), number(1234.5), number(123456.0)
    ('1.23e-04', '12.3', '1,234', '1.23e+05')
    """
    if value != 0.0 and (abs(value) < _SMALL or abs(value) >= _LARGE):
        return f"{value:.2e}"
    return f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
