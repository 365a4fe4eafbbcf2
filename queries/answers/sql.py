"""Questions in SQL: one statement that reads, on a connection that can do nothing else."""

import csv
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

import duckdb

from queries.answers.table import Table
from queries.database import connection as database
from queries.database.connection import ResultsError

_READING = ("SELECT", "EXPLAIN")
_EXPLAIN = re.compile(r"^\s*explain(\s+analyze)?\b", re.IGNORECASE)
_ROWS = ("generate_series", "json_each", "json_tree", "range", "repeat", "repeat_row", "unnest")
"""Functions of DuckDB that give rows of what they are given, and do nothing else."""
_SHOWN_ROWS = 1000
_FETCHED_ROWS = 10_000


def query(
    connection: duckdb.DuckDBPyConnection,
    statement: str,
    parameters: Mapping[str, Any] | Sequence[Any] = (),
) -> duckdb.DuckDBPyConnection:
    """Run one statement that reads, and return the connection to fetch its rows from.

    Parameters
    ----------
    connection
        As `queries.database.connection.connect` gives it: it refuses what this check might let pass.
    statement
        One SELECT, FROM, WITH, VALUES, DESCRIBE, SHOW, SUMMARIZE or EXPLAIN.
    parameters
        Values of its placeholders, by place or by name.

    Raises
    ------
    ResultsError
        If it is no such statement, or DuckDB refuses it.
    """
    try:
        found = duckdb.extract_statements(statement)
    except duckdb.Error as error:
        raise ResultsError(_line(error)) from error
    if len(found) != 1:
        raise ResultsError(f"one statement is expected, {len(found)} are given")
    kind = found[0].type.name
    if kind not in _READING:
        raise ResultsError(f"only statements that read are allowed, such as SELECT; this one is {kind}")
    refused = sorted(set(_table_functions(connection, statement)) - _allowed(connection))
    if refused:
        raise ResultsError(f"{', '.join(refused)}: functions that do more than give rows are not allowed")
    try:
        return connection.execute(found[0], parameters)
    except duckdb.Error as error:
        raise ResultsError(_line(error)) from error


def _table_functions(connection: duckdb.DuckDBPyConnection, statement: str) -> Iterator[str]:
    """Yield the functions that a statement calls for rows: some change settings or write logs.

    Raises
    ------
    ResultsError
        If DuckDB cannot tell.
    """
    text = _EXPLAIN.sub("", statement.rstrip().rstrip(";"), count=1)
    (tree,) = connection.execute("SELECT json_serialize_sql($1::VARCHAR)", [text]).fetchone() or ("{}",)
    parsed = json.loads(tree)
    if parsed.get("error"):
        raise ResultsError(_line(duckdb.Error(str(parsed.get("error_message", "the statement is refused")))))
    nodes: list[Any] = [parsed]
    while nodes:
        node = nodes.pop()
        if isinstance(node, dict):
            if node.get("type") == "TABLE_FUNCTION":
                yield str(node["function"].get("function_name", "")).lower()
            nodes += node.values()
        elif isinstance(node, list):
            nodes += node


def _allowed(connection: duckdb.DuckDBPyConnection) -> set[str]:
    """Return the functions for rows that only read: of the database, of what they are given, and macros."""
    rows = connection.execute(
        "SELECT function_name FROM duckdb_functions() WHERE function_type = 'table_macro' "
        "OR (function_type = 'table' AND (function_name LIKE 'duckdb\\_%' ESCAPE '\\' "
        "OR function_name LIKE 'pragma\\_%' ESCAPE '\\'))"
    ).fetchall()
    return {*_ROWS, *(row[0].lower() for row in rows)}


def answer(
    named: Path | str,
    statement: str,
    form: str = "table",
    output: Path | None = None,
    parameters: Mapping[str, Any] | Sequence[Any] = (),
) -> None:
    """Answer one question about results on the terminal or in a file.

    Parameters
    ----------
    named
        Run directory or database file.
    statement, parameters
        See `query`.
    form
        table, csv or parquet.
    output
        File to write; standard output if not given, which cannot take parquet.

    Raises
    ------
    ResultsError
        If there are no results, the statement is refused, or the file cannot be written.
    """
    if form == "parquet" and output is None:
        raise ResultsError("parquet is no text: name a file with --output")
    with database.connect(named) as connection:
        result = query(connection, statement, parameters)
        try:
            if form == "parquet" and output is not None:
                _write_parquet(result, output)
            elif output is not None:
                with output.open("w", newline="", encoding="utf-8") as file:
                    _write(result, form, file)
            else:
                _write(result, form, sys.stdout)
        except OSError as error:
            raise ResultsError(f"{output}: cannot be written: {error.strerror}") from error
        except duckdb.Error as error:
            raise ResultsError(_line(error)) from error


def _write(result: duckdb.DuckDBPyConnection, form: str, file: TextIO) -> None:
    if form == "csv":
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_names(result))
        writer.writerows(_rows(result))
        return
    from rich.console import Console

    rows = result.fetchmany(_SHOWN_ROWS + 1)
    note = f"The first {_SHOWN_ROWS} rows; --format csv gives all." if len(rows) > _SHOWN_ROWS else ""
    cells = tuple(
        tuple("NULL" if value is None else str(value) for value in row) for row in rows[:_SHOWN_ROWS]
    )
    names = _names(result)
    Table("", tuple(names), cells, words=len(names), note=note).show(Console(file=file))


def _write_parquet(result: duckdb.DuckDBPyConnection, output: Path) -> None:
    """Write rows through a second, empty database: the one that reads results cannot write anywhere."""
    frame = result.fetchdf()
    with duckdb.connect(":memory:") as writer:
        writer.from_df(frame).write_parquet(str(output))


def _names(result: duckdb.DuckDBPyConnection) -> list[str]:
    return [column[0] for column in result.description or []]


def _rows(result: duckdb.DuckDBPyConnection) -> Iterator[tuple[Any, ...]]:
    while rows := result.fetchmany(_FETCHED_ROWS):
        yield from rows


def _line(error: duckdb.Error) -> str:
    """Return the error in one line, with what DuckDB proposes instead."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    keep = [line for line in lines if not line.startswith(("LINE ", "^"))]
    return " ".join(keep[:3]) if keep else "the statement is refused"
