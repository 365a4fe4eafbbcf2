"""Inserting rows into a database, many at once: every statement costs milliseconds."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

_NUMBERS = ("INTEGER", "BIGINT", "DOUBLE")
_HELD_ROWS = 400_000
"""Rows of a table that are buffered before they are inserted, some 10 MB."""

Columns = Sequence[tuple[str, str]]
"""Names and types of columns."""


@dataclass
class _Stretches:
    """Buffered stretches of rows: text once per stretch, numbers in arrays as they came."""

    heads: list[Mapping[str, Any]] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    rows: int = 0
    numbers: dict[str, list[NDArray[Any]]] = field(default_factory=dict)


class Writer:
    """Inserts into the tables of one database, by the names and types of their columns."""

    def __init__(self, connection: duckdb.DuckDBPyConnection) -> None:
        self.connection = connection
        self._columns: dict[str, list[tuple[str, str]]] = {}
        self._waiting: dict[str, _Stretches] = {}
        for table, name, kind in connection.execute(
            "SELECT table_name, column_name, data_type FROM duckdb_columns() WHERE NOT internal ORDER BY ALL"
        ).fetchall():
            self._columns.setdefault(table, []).append((name, kind))

    def rows(self, table: str, rows: Iterable[Mapping[str, Any]], replacing: Sequence[str] = ()) -> None:
        """Insert rows; missing values become NULL, and columns that the table lacks are left out.

        Parameters
        ----------
        table
            Its name.
        rows
            Values by column.
        replacing
            Columns; rows that agree in them with a new one are removed first.
        """
        rows = list(rows)
        if not rows:
            return
        columns = self._columns[table]
        values = _to_arrays(columns, rows)
        self.connection.register("new", values)
        if replacing:
            same = " AND ".join(f'{table}."{name}" = new."{name}"' for name in replacing)
            self.connection.execute(f"DELETE FROM {table} USING new WHERE {same}")
        self._insert(table, values, "new")

    def stretches(
        self, table: str, heads: Sequence[Mapping[str, Any]], numbers: Mapping[str, NDArray[Any]]
    ) -> None:
        """Insert stretches of rows: each head with as many rows as `numbers` has columns.

        Parameters
        ----------
        table
            Its name.
        heads
            Values that all rows of a stretch share.
        numbers
            Columns of shape (head, row); NaN becomes NULL.
        """
        waiting = self._waiting.setdefault(table, _Stretches())
        size = next(iter(numbers.values())).shape[1]
        for name, array in numbers.items():
            waiting.numbers.setdefault(name, []).append(array)
        waiting.heads += heads
        waiting.sizes += [size] * len(heads)
        waiting.rows += size * len(heads)
        if waiting.rows > _HELD_ROWS:
            self._flush(table)

    def flush(self) -> None:
        """Insert and commit all buffered stretches."""
        for table in list(self._waiting):
            self._flush(table)

    def _flush(self, table: str) -> None:
        """Insert and commit the stretches of a table: the memory of a transaction grows with its rows."""
        waiting = self._waiting.pop(table)
        numbers = {name: _concatenate(parts) for name, parts in waiting.numbers.items()}
        shared = [(name, kind) for name, kind in self._columns[table] if name not in numbers]
        heads = _to_arrays(shared, waiting.heads)
        if any(kind not in _NUMBERS for _, kind in shared):
            place = np.arange(len(waiting.heads), dtype=np.int32)
            self.connection.register("heads", {**heads, "head": place})
            self.connection.register("new", {**numbers, "head": np.repeat(place, waiting.sizes)})
            relation = "new JOIN heads USING (head)"
        else:  # numbers alone need no join
            heads = {name: np.repeat(values, waiting.sizes) for name, values in heads.items()}
            self.connection.register("new", {**numbers, **heads})
            relation = "new"
        self._insert(table, {**numbers, **heads}, relation)
        self.connection.commit()
        self.connection.begin()

    def _insert(self, table: str, values: Mapping[str, NDArray[Any]], relation: str) -> None:
        """Insert the rows of a relation in which every column has the name of its target."""
        columns = self._columns[table]
        names = ", ".join(f'"{name}"' for name, _ in columns)
        expressions = ", ".join(_expression(name, kind, values[name]) for name, kind in columns)
        self.connection.execute(f"INSERT INTO {table} ({names}) SELECT {expressions} FROM {relation}")
        self.connection.unregister("new")


def _concatenate(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Return the elements of arrays in one array; the arrays may be broadcast views."""
    joined = np.empty(sum(part.size for part in parts), np.result_type(*parts))
    first = 0
    for part in parts:
        joined[first : first + part.size].reshape(part.shape)[...] = part
        first += part.size
    return joined


def _to_arrays(columns: Columns, rows: Sequence[Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    """Return rows as arrays for DuckDB, in which NaN or an empty text stands for NULL."""
    arrays: dict[str, NDArray[Any]] = {}
    for name, kind in columns:  # not every version of DuckDB reads object arrays with None
        values = [row.get(name) for row in rows]
        if kind in _NUMBERS:
            numbers = np.array([np.nan if value is None else value for value in values])
            arrays[name] = numbers if numbers.dtype.kind == "i" else numbers.astype(float)
        else:
            arrays[name] = np.array(["" if value is None else str(value) for value in values], dtype=object)
    return arrays


def _expression(name: str, kind: str, values: NDArray[Any]) -> str:
    """Return the SQL expression that turns an array into its column."""
    if kind not in _NUMBERS:
        return f"nullif(\"{name}\", '')::{kind}"
    if np.isnan(values).any():
        return f'CASE WHEN NOT isnan("{name}"::DOUBLE) THEN "{name}"::{kind} END'
    return f'"{name}"::{kind}'
