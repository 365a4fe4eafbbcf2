"""The report: summary, figures to explore, tables and provenance in one page that needs no network."""

import importlib.util
import json
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import duckdb
from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from queries import answers
from queries.answers import Pair
from queries.database import ResultsError, reason, snapshot
from queries.report.data import data

_PAGE = resources.files("queries.report") / "page"
_MOST_ROWS = 2000
"""Rows up to which a table of errors has one per case and receiver."""
_SCRIPTS = ("data.js", "plots.js", "figures.js", "page.js")


def write_report(connection: duckdb.DuckDBPyConnection, path: Path) -> Path:
    """Write the report of results and return its path; every number comes from the database.

    Raises
    ------
    ResultsError
        If the file cannot be written.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            for piece in page(
                connection
            ):  # piecewise, as one text of megabytes would take two bytes a letter
                file.write(piece.encode())
        partial.replace(path)
    except OSError as error:
        raise ResultsError(f"{path}: cannot be written: {reason(error)}") from error
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
    return path


def shown_snapshot(path: Path) -> tuple[str, ...]:
    """Return the digests of the snapshot that a report shows, see `database.snapshot`; () for no report."""
    try:
        with path.open(encoding="utf-8") as file:
            head = file.read(1000)
    except (OSError, UnicodeDecodeError):
        return ()
    match = re.search('name="railvib-snapshot" content="([0-9a-f]+) ([0-9a-f]+)"', head)
    return match.groups() if match else ()


def page(connection: duckdb.DuckDBPyConnection) -> Iterator[str]:
    """Return the page, piece by piece."""
    query = (
        "SELECT coalesce(resolved_study ->> '$.study.title', study) FROM runs ORDER BY sequence DESC LIMIT 1"
    )
    row = connection.execute(query).fetchone()
    content = {
        "study": str(row[0] if row and row[0] else "results"),
        "snapshot": " ".join(snapshot(connection)),
        "verdicts": answers.verdicts(connection),
        "sentences": answers.summary(connection),
        "missing": answers.missing_notes(connection),
        "extrapolated": answers.extrapolation_notes(connection),
        "tables": [
            *(
                answers.error_table(connection, pair, by)
                for pair in answers.pairs(connection)
                for by in _groupings(connection, pair)
            ),
            answers.cost_table(connection, by_case=True),
        ],
        "provenance": answers.provenance_tables(connection),
    }
    # Last: narrow-band lines fill DuckDB's memory, after which queries take half as long again.
    figures = data(connection)
    return (
        _environment()
        .get_template("report.html")
        .generate(
            content,
            data=figures,
            thinned=_thinning_note(figures["lines"]),
            style=Markup(_text("report.css")),
            scripts=[Markup(_text(name)) for name in _SCRIPTS],
            plotly=Markup(_plotly()),
        )
    )


def _groupings(connection: duckdb.DuckDBPyConnection, pair: Pair) -> list[tuple[str, ...] | None]:
    """Return groupings of error tables: case and receiver, or each alone if there are many rows."""
    query = f"SELECT count(*) FROM (SELECT DISTINCT case_id, receiver, offset_m FROM ({pair.rows}))"
    row = connection.execute(query, dict(pair.parameters)).fetchone()
    few = not row or row[0] <= _MOST_ROWS
    return [None] if few else [(*answers.varying(connection),), ("receiver",)]


def _thinning_note(lines: dict[str, Any]) -> str:
    """Say which narrow-band lines the page has."""
    if not lines["lines"]:
        return "The database holds no narrow-band lines: the study leaves them to the store."
    if not lines["bins"]:
        return f"All {lines['lines']:,} lines of each spectrum are drawn."
    text = (
        f"To keep this page small, each spectrum of up to {lines['lines']:,} lines is thinned to the "
        f"smallest and the largest line of each of {lines['bins']:,} bins of frequency, so that peaks and "
        "dips stay"
    )
    if lines["dynamic_only"]:
        text += "; only the dynamic contribution is here"
    if lines["cases"] < lines["of_cases"]:
        text += f"; {lines['cases']} of {lines['of_cases']} cases have one"
    return text + ". The database has every line."


@cache
def _environment() -> Environment:
    environment = Environment(
        autoescape=True,
        loader=FunctionLoader(_text),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["json"] = _json
    return environment


def _json(value: Any) -> Markup:
    """Return a value as JSON that is safe in a script element."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _text(name: str) -> str:
    return (_PAGE / name).read_text("utf-8")


def _plotly() -> str:
    """Return the plotting library from its Python package, without importing that, which is slow."""
    package = importlib.util.find_spec("plotly")
    assert package is not None
    assert package.submodule_search_locations is not None
    place = Path(package.submodule_search_locations[0]) / "package_data" / "plotly.min.js"
    return place.read_text("utf-8")
