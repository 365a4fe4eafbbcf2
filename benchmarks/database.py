"""The database of benchmarks: built from the JSON files in a folder, one row per figure."""

import json
import os
from importlib import resources
from pathlib import Path
from typing import Any

import duckdb

from queries.database import schema

DATABASE = "benchmarks.duckdb"

_FIGURE = (
    "section", "item", "case", "quantity", "unit", "samples", "median", "lower_quartile", "upper_quartile",
    "at_least", "at_most", "holds",
)  # fmt: skip


def rebuild(folder: Path) -> Path:
    """Rebuild the database of all benchmarks in a folder and replace the previous one in one step."""
    path = folder / DATABASE
    partial = folder / f"{DATABASE}.{os.getpid()}.partial"
    partial.unlink(missing_ok=True)
    with schema.open_for_writing(partial) as connection:
        connection.execute((resources.files("benchmarks") / "database.sql").read_text("utf-8"))
        for file in sorted(folder.glob("benchmark-*.json")):
            _add(connection, file.stem, json.loads(file.read_text(encoding="utf-8")))
    partial.replace(path)
    return path


def _add(connection: duckdb.DuckDBPyConnection, name: str, document: dict[str, Any]) -> None:
    """Add one benchmark and its figures."""
    rates = document["rates"]
    row = [
        name,
        *(document[key] for key in ("started", "finished", "size", "host", "host_class", "processors")),
        *(document[key] for key in ("load_before", "load_after", "commit", "model_version")),
        json.dumps(document["versions"]),
        *(rates[key] for key in ("operations", "divisions", "roots")),
    ]
    connection.execute(f"INSERT INTO benchmarks VALUES ({', '.join('?' * len(row))})", row)
    rows = [[name, *(figure[key] for key in _FIGURE)] for figure in document["figures"]]
    if rows:
        connection.executemany(f"INSERT INTO figures VALUES ({', '.join('?' * len(rows[0]))})", rows)
