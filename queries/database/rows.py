"""Rows into the tables of a database: many at once, for every statement costs milliseconds."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

_NUMBERS = ("INTEGER", "BIGINT", "DOUBLE")
_HELD_ROWS = 400_000
"""Rows of a table that are held in memory before they are inserted, some 10 MB."""


@dataclass
class _Held:
    """Rows that wait: words once per stretch of rows, numbers in arrays as they came."""

    heads: list[Mapping[str, Any]] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    rows: int = 0
    numbers: dict[str, list[NDArray[Any]]] = field(default_factory=dict)


class Writer:
    """Inserts into the tables of one database, by the names and types of their columns."""

    def __init__(self, connection: duckdb.DuckDBPyConnection) -> None:
        self.connection = connection
        self._columns: dict[str, list[tuple[str, str]]] = {}
        self._held: dict[str, _Held] = {}
        for table, name, kind in connection.execute(
            "SELECT table_name, column_name, data_type FROM duckdb_columns() WHERE NOT internal "
            "ORDER BY table_name, column_index"
        ).fetchall():
            self._columns.setdefault(table, []).append((name, kind))

    def rows(self, table: str, rows: Iterable[Mapping[str, Any]]) -> None:
        """Insert rows; what a row lacks becomes NULL, what a table lacks is left out."""
        rows = list(rows)
        if rows:
            sent = _sent(self._columns[table], rows)
            self.connection.register("given", sent)
            self._insert(table, sent, "given")

    def stretches(
        self, table: str, heads: Sequence[Mapping[str, Any]], numbers: Mapping[str, NDArray[Any]]
    ) -> None:
        """Insert stretches of rows: each head with as many rows as `numbers` has columns.

        Parameters
        ----------
        table
            Its name.
        heads
            What all rows of a stretch share.
        numbers
            Columns of shape (head, row); NaN becomes NULL.
        """
        held = self._held.setdefault(table, _Held())
        for name, array in numbers.items():
            held.numbers.setdefault(name, []).append(array)
            size = array.shape[1]
        held.heads += heads
        held.sizes += [size] * len(heads)
        held.rows += size * len(heads)
        if held.rows > _HELD_ROWS:
            self._flush(table)

    def flush(self) -> None:
        """Insert all that is held, for good."""
        for table in list(self._held):
            self._flush(table)

    def _flush(self, table: str) -> None:
        """Insert what is held of a table, for good: the memory of a transaction grows with its rows."""
        held = self._held.pop(table)
        numbers = {name: _joined(parts) for name, parts in held.numbers.items()}
        shared = [(name, kind) for name, kind in self._columns[table] if name not in numbers]
        heads = _sent(shared, held.heads)
        if any(kind not in _NUMBERS for _, kind in shared):
            place = np.arange(len(held.heads), dtype=np.int32)
            self.connection.register("heads", {**heads, "head": place})
            self.connection.register("given", {**numbers, "head": np.repeat(place, held.sizes)})
            source = "given JOIN heads USING (head)"
        else:  # numbers alone need no join
            heads = {name: np.repeat(sent, held.sizes) for name, sent in heads.items()}
            self.connection.register("given", {**numbers, **heads})
            source = "given"
        self._insert(table, {**numbers, **heads}, source)
        self.connection.commit()
        self.connection.begin()

    def _insert(self, table: str, sent: Mapping[str, NDArray[Any]], source: str) -> None:
        columns = (_received(name, kind, sent[name]) for name, kind in self._columns[table])
        self.connection.execute(f"INSERT INTO {table} SELECT {', '.join(columns)} FROM {source}")
        self.connection.unregister("given")


def _joined(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Return the elements of arrays one after the other; they may be views of fewer elements."""
    joined = np.empty(sum(part.size for part in parts), np.result_type(*parts))
    first = 0
    for part in parts:
        joined[first : first + part.size].reshape(part.shape)[...] = part
        first += part.size
    return joined


def _sent(columns: Iterable[tuple[str, str]], rows: Sequence[Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    """Return rows as columns that DuckDB takes."""
    # NULL travels as NaN or as an empty text: not every DuckDB reads arrays of objects with gaps.
    sent: dict[str, NDArray[Any]] = {}
    for name, kind in columns:
        given = [row.get(name) for row in rows]
        if kind in _NUMBERS:
            numbers = np.array([np.nan if value is None else value for value in given])
            sent[name] = numbers if numbers.dtype.kind == "i" else numbers.astype(float)
        else:
            sent[name] = np.array(["" if value is None else str(value) for value in given], dtype=object)
    return sent


def _received(name: str, kind: str, sent: NDArray[Any]) -> str:
    """Return the expression that makes a column of what was sent."""
    if kind not in _NUMBERS:
        return f"nullif(\"{name}\", '')::{kind}"
    if np.isnan(sent).any():
        return f'CASE WHEN NOT isnan("{name}"::DOUBLE) THEN "{name}"::{kind} END'
    return f'"{name}"::{kind}'
