"""The results in DuckDB: schema, ingest of records and arrays, and connections."""

from queries.database.connection import connect, fetch_columns, fill_gaps, snapshot
from queries.database.ingest import Ingest, begin, ingest, is_outdated
from queries.database.place import DATABASE, Place, ResultsError, duckdb_path, locate, quote, reason

__all__ = [
    "DATABASE",
    "Ingest",
    "Place",
    "ResultsError",
    "begin",
    "connect",
    "duckdb_path",
    "fetch_columns",
    "fill_gaps",
    "ingest",
    "is_outdated",
    "locate",
    "quote",
    "reason",
    "snapshot",
]
