"""The database of benchmarks: derived from the JSON files that they leave in a folder, one row per figure."""

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


def ingest(folder: Path) -> Path:
    """Make the database of all benchmarks in a folder anew, and put it in place in one step."""
    path = folder / DATABASE
    fresh = folder / f"{DATABASE}.{os.getpid()}.partial"
    fresh.unlink(missing_ok=True)
    with schema.open_for_writing(fresh) as connection:
        connection.execute(_tables())
        for file in sorted(folder.glob("benchmark-*.json")):
            _add(connection, file.stem, json.loads(file.read_text(encoding="utf-8")))
    fresh.replace(path)
    return path


def _tables() -> str:
    return (resources.files("benchmarks") / "database.sql").read_text("utf-8")


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


def after_benchmark(folder: Path | str) -> None:
    """Bring the database of a folder up to date with a benchmark that has just ended, and say where it is."""
    print(f"database  {ingest(Path(folder))}")
