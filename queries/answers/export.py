"""Results as Parquet files, for readers without railvib and without DuckDB."""

import csv
import os
import shutil
from pathlib import Path

import duckdb

from queries.database import ResultsError, connect, duckdb_path, locate, quote, reason
from queries.statements import statements

_SQL = statements("queries.answers", "export")

PARTITIONS = {
    "levels": ("approach", "quantity"),
    "accuracy": ("approach", "quantity"),
    "psd": ("approach", "case_id"),
}
"""Large tables and views, with the columns that partition them into folders named column=value."""

SINGLE = (
    "runs",
    "cases",
    "case_parameters",
    "runtime",
    "tradeoff",
    "costs",
    "missing",
    "failures",
    "receptances",
    "unevenness_bands",
    "soils",
    "soil_layers",
    "tracks",
    "track_layers",
    "trains",
    "vehicles",
    "axles",
    "unevenness",
)
"""Small tables and views, one file each."""

_COLUMNS = "columns.csv"


def export(named: Path | str, folder: Path) -> list[str]:
    """Write results as Parquet files into a new folder, and return the names of the files.

    Parameters
    ----------
    named
        Run directory or database file.
    folder
        Created; must be new or empty.

    Raises
    ------
    ResultsError
        If there are no results, or the folder holds something.
    """
    place = locate(named)
    with connect(named):  # refuses databases of other versions
        path = duckdb_path(place.path)
    partial = folder.with_name(f"{folder.name}.{os.getpid()}.partial")
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise ResultsError(f"{folder}: is there already; an export needs a folder of its own")
        partial.mkdir(parents=True)
        with duckdb.connect(":memory:") as connection:
            connection.execute(f"ATTACH {quote(path)} AS results (READ_ONLY)")
            connection.execute("USE results")
            for table, columns in PARTITIONS.items():
                _copy(connection, table, partial / table, f", PARTITION_BY ({', '.join(columns)})")
            for table in SINGLE:
                _copy(connection, table, partial / f"{table}.parquet")
            _write_columns(connection, partial / _COLUMNS)
        if folder.exists():
            folder.rmdir()
        partial.rename(folder)
    except (OSError, duckdb.Error) as error:
        raise ResultsError(f"{folder}: cannot be written: {reason(error)}") from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return [*(f"{table}/" for table in PARTITIONS), *(f"{table}.parquet" for table in SINGLE), _COLUMNS]


def _copy(connection: duckdb.DuckDBPyConnection, table: str, path: Path, options: str = "") -> None:
    file = quote(str(path.absolute()))
    connection.execute(f"COPY (FROM {table}) TO {file} (FORMAT parquet, COMPRESSION zstd{options})")


def _write_columns(connection: duckdb.DuckDBPyConnection, path: Path) -> None:
    """Write meaning and unit of every column: no Parquet metadata is shown by all readers."""
    rows = connection.execute(_SQL["columns"], [[*PARTITIONS, *SINGLE]]).fetchall()
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("table", "column", "type", "meaning"))
        writer.writerows(rows)
