"""The approaches of the results: their order, how they are called in sentences, and the reference."""

from collections.abc import Iterable

import duckdb

from queries.answers.table import plain

_LABELS = {
    "moving-roughness": "moving roughness",
    "moving-roughness-by-axle": "moving roughness by axle",
    "moving-roughness-uncorrelated": "moving roughness, uncorrelated axles",
    "full": "full model",
    "fe-be": "finite and boundary elements",
}
"""In the order in which tables and figures show them; unknown ones follow by name."""


def label(approach: str) -> str:
    """Return how an approach is called in legends and sentences."""
    return _LABELS.get(approach, plain(approach))


def rank(approach: str) -> tuple[int, str]:
    """Return the key by which approaches are sorted."""
    known = list(_LABELS)
    return known.index(approach) if approach in known else len(known), approach


def in_order(approaches: Iterable[str]) -> list[str]:
    """Return approaches, each once, in the order in which they are shown."""
    return sorted(set(approaches), key=rank)


def requested_approaches(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return the approaches that the runs asked for, in the order in which they are shown."""
    rows = connection.execute("SELECT DISTINCT approach FROM current_units").fetchall()
    return in_order(name for (name,) in rows)


def reference(connection: duckdb.DuckDBPyConnection) -> str:
    """Return the approach that the newest run compares with."""
    row = connection.execute("SELECT reference FROM runs ORDER BY sequence DESC LIMIT 1").fetchone()
    return str(row[0]) if row and row[0] else "full"
