"""The approaches of the results: their order, their labels, and the reference."""

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
"""Labels in the order of tables and figures; unknown approaches follow by name."""


def label(approach: str) -> str:
    """Return the label of an approach in legends and sentences."""
    return _LABELS.get(approach, plain(approach))


def rank(approach: str) -> tuple[int, str]:
    """Return the sort key of an approach."""
    known = list(_LABELS)
    return known.index(approach) if approach in known else len(known), approach


def in_order(approaches: Iterable[str]) -> list[str]:
    """Return approaches without repetitions, in display order."""
    return sorted(set(approaches), key=rank)


def requested_approaches(connection: duckdb.DuckDBPyConnection) -> list[str]:
    """Return the approaches that runs have requested, in display order."""
    rows = connection.execute("SELECT DISTINCT approach FROM current_units").fetchall()
    return in_order(name for (name,) in rows)


def reference(connection: duckdb.DuckDBPyConnection) -> str:
    """Return the reference approach of the newest run."""
    row = connection.execute("SELECT reference FROM runs ORDER BY sequence DESC LIMIT 1").fetchone()
    return str(row[0]) if row and row[0] else "full"
