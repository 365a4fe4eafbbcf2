"""Questions in SQL: one read-only statement, on a read-only connection, within limits."""

import csv
import json
import re
import resource
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Timer
from typing import Any, TextIO

import duckdb
import psutil

from queries.answers.table import Table
from queries.database import ResultsError, connect, reason
from queries.statements import statements

_SQL = statements("queries.answers", "sql")
_READING = ("SELECT", "EXPLAIN")
_EXPLAIN = re.compile(r"^\s*explain(\s+analyze)?\b", re.IGNORECASE)
_ROW_FUNCTIONS = ("generate_series", "json_each", "json_tree", "range", "repeat", "repeat_row", "unnest")
"""Table functions of DuckDB that only turn their arguments into rows."""
_SHOWN_ROWS = 1000
_FETCHED_ROWS = 10_000
_OVERHEAD_BYTES = 2**28
"""Memory for threads and printing, beside that of a query."""


@dataclass(frozen=True)
class Limits:
    """Limits of an answer: time, memory, and characters on the terminal."""

    seconds: float = 60.0
    memory_mb: float = 2000.0
    printed_mb: float = 100.0


def query(
    connection: duckdb.DuckDBPyConnection,
    statement: str,
    parameters: Mapping[str, Any] | Sequence[Any] = (),
) -> duckdb.DuckDBPyConnection:
    """Run one read-only statement, and return the connection to fetch its rows from.

    Parameters
    ----------
    connection
        From `queries.database.connect`, which refuses what this check might miss.
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
        parsed = duckdb.extract_statements(statement)
    except duckdb.Error as error:
        raise ResultsError(_line(error)) from error
    if len(parsed) != 1:
        raise ResultsError(f"one statement is expected, {len(parsed)} are given")
    kind = parsed[0].type.name
    if kind not in _READING:
        raise ResultsError(f"only statements that read are allowed, such as SELECT; this one is {kind}")
    refused = sorted(set(_table_functions(connection, statement)) - _reading_functions(connection))
    if refused:
        raise ResultsError(f"{', '.join(refused)}: functions that do more than give rows are not allowed")
    try:
        return connection.execute(parsed[0], parameters)
    except (duckdb.InterruptException, duckdb.OutOfMemoryException):
        raise
    except duckdb.Error as error:
        raise ResultsError(_line(error)) from error


def _table_functions(connection: duckdb.DuckDBPyConnection, statement: str) -> Iterator[str]:
    """Yield the table functions that a statement calls: some change settings or write logs.

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


def _reading_functions(connection: duckdb.DuckDBPyConnection) -> set[str]:
    """Return the table functions that only read, including macros."""
    rows = connection.execute(_SQL["functions-that-read"]).fetchall()
    return {*_ROW_FUNCTIONS, *(row[0].lower() for row in rows)}


def answer(
    named: Path | str,
    statement: str,
    form: str = "table",
    output: Path | None = None,
    parameters: Mapping[str, Any] | Sequence[Any] = (),
    limits: Limits = Limits(),
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
    limits
        What the answer may take.

    Raises
    ------
    ResultsError
        If there are no results, the statement is refused, a limit is reached, or the file cannot be written.
    """
    if form == "parquet" and output is None:
        raise ResultsError("parquet is no text: name a file with --output")
    memory = f"{limits.memory_mb:.0f}MB"
    with connect(named, memory=memory) as connection, _enforce(connection, limits) as expired:
        result = query(connection, statement, parameters)
        try:
            if form == "parquet" and output is not None:
                _write_parquet(result, output)
            elif output is not None:
                with output.open("w", newline="", encoding="utf-8") as file:
                    _write(result, form, file, expired)
            else:
                _write(result, form, _Printed(sys.stdout, limits.printed_mb), expired)
        except BrokenPipeError:
            raise
        except OSError as error:
            raise ResultsError(f"{output or 'the answer'}: cannot be written: {reason(error)}") from error


@contextmanager
def _enforce(connection: duckdb.DuckDBPyConnection, limits: Limits) -> Iterator[Event]:
    """Turn a query that takes too long or too much memory into an error of one line.

    Yields an event that is set as soon as time is up.
    """
    expired = Event()

    def stop() -> None:
        expired.set()
        connection.interrupt()

    timer = Timer(limits.seconds, stop)
    timer.daemon = True
    timer.start()
    try:
        with _limit_memory(limits.memory_mb):
            yield expired
    except duckdb.InterruptException as error:
        if not expired.is_set():
            raise KeyboardInterrupt from error
        raise ResultsError(
            f"takes longer than {limits.seconds:g} s; --time-limit sets another limit"
        ) from error
    except (duckdb.OutOfMemoryException, MemoryError) as error:
        raise ResultsError(
            f"takes more than {limits.memory_mb:g} MB of memory; --memory-limit sets another limit"
        ) from error
    except duckdb.Error as error:
        raise ResultsError(_line(error)) from error
    finally:
        timer.cancel()


@contextmanager
def _limit_memory(megabytes: float) -> Iterator[None]:
    """Limit the memory of this process inside the block: DuckDB does not count long texts."""
    before = resource.getrlimit(resource.RLIMIT_DATA)
    used = getattr(psutil.Process().memory_info(), "data", None)  # on Linux
    if used is not None:
        most = int(used + megabytes * 1e6 + _OVERHEAD_BYTES)
        soft = most if before[0] == resource.RLIM_INFINITY else min(most, before[0])
        resource.setrlimit(resource.RLIMIT_DATA, (soft, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


class _Printed:
    """Standard output with a limit on its number of characters."""

    def __init__(self, file: TextIO, megabytes: float) -> None:
        self._file = file
        self._megabytes = megabytes
        self._left = megabytes * 1e6

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def write(self, text: str) -> int:
        """Write text, unless it is too much.

        Raises
        ------
        ResultsError
            If it is.
        """
        self._left -= len(text)
        if self._left < 0:
            raise ResultsError(
                f"the answer is longer than {self._megabytes:g} MB; --print-limit sets another limit, "
                "--output writes it to a file"
            )
        return self._file.write(text)


def _write(result: duckdb.DuckDBPyConnection, form: str, file: Any, expired: Event) -> None:
    names = [column[0] for column in result.description or []]
    if form == "csv":
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        while rows := result.fetchmany(_FETCHED_ROWS):
            writer.writerows(rows)
            if expired.is_set():
                raise duckdb.InterruptException
        return
    from rich.console import Console

    rows = result.fetchmany(_SHOWN_ROWS + 1)
    note = f"The first {_SHOWN_ROWS} rows; --format csv gives all." if len(rows) > _SHOWN_ROWS else ""
    cells = tuple(
        tuple("NULL" if value is None else str(value) for value in row) for row in rows[:_SHOWN_ROWS]
    )
    Table("", tuple(names), cells, words=len(names), note=note).show(Console(file=file))


def _write_parquet(result: duckdb.DuckDBPyConnection, output: Path) -> None:
    """Write rows through a second, empty database: the read-only connection cannot write files."""
    frame = result.fetchdf()
    with duckdb.connect(":memory:") as writer:
        writer.from_df(frame).write_parquet(str(output.absolute()))


def _line(error: duckdb.Error) -> str:
    """Return the error in one line, with DuckDB's suggestion."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    text_lines = [line for line in lines if not line.startswith(("LINE ", "^"))]
    return " ".join(text_lines[:3]) if text_lines else "the statement is refused"
