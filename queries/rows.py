"""Rows and columns into the tables of a database, each by one statement."""

from collections.abc import Iterable, Mapping
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

_NUMBERS = ("INTEGER", "BIGINT", "DOUBLE")


class Writer:
    """Inserts into the tables of one database, by the names and types of their columns."""

    def __init__(self, connection: duckdb.DuckDBPyConnection) -> None:
        self.connection = connection
        self._columns: dict[str, list[tuple[str, str]]] = {}
        for table, name, kind in connection.execute(
            "SELECT table_name, column_name, data_type FROM duckdb_columns() WHERE NOT internal "
            "ORDER BY table_name, column_index"
        ).fetchall():
            self._columns.setdefault(table, []).append((name, kind))

    def rows(self, table: str, rows: Iterable[Mapping[str, Any]]) -> None:
        """Insert rows; what a row lacks becomes NULL, what a table lacks is left out."""
        rows = list(rows)
        if rows:
            names = [name for name, _ in self._columns[table]]
            self.columns(table, {name: [row.get(name) for row in rows] for name in names})

    def columns(self, table: str, values: Mapping[str, Any]) -> None:
        """Insert columns of equal length, arrays or lists; None, NaN and empty texts become NULL."""
        # NULL travels as NaN or as an empty text: not every DuckDB reads arrays of objects with gaps.
        sent: dict[str, NDArray[Any]] = {}
        received = []
        for name, kind in self._columns[table]:
            given = values[name]
            if kind in _NUMBERS:
                if isinstance(given, list):
                    given = [np.nan if value is None else value for value in given]
                sent[name] = np.ascontiguousarray(given, dtype=float)
                received.append(f'CASE WHEN NOT isnan("{name}") THEN "{name}"::{kind} END')
            else:
                sent[name] = np.array(["" if value is None else str(value) for value in given], dtype=object)
                received.append(f"nullif(\"{name}\", '')::{kind}")
        self.plain(table, sent, received)

    def plain(
        self, table: str, arrays: Mapping[str, NDArray[Any]], expressions: Iterable[str] | None = None
    ) -> None:
        """Insert arrays as they are, or what expressions make of them; the quickest way for many numbers."""
        self.connection.register("given", dict(arrays))
        self.connection.execute(f"INSERT INTO {table} SELECT {', '.join(expressions or arrays)} FROM given")
        self.connection.unregister("given")
