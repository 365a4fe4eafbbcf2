"""Verification of a run's database."""

from pathlib import Path

import duckdb

from queries.database.connection import attach
from queries.database.place import DATABASE, ResultsError, reason


def verify(directory: Path, repair: bool = False) -> list[str]:
    """Read every value of the database of a run directory; return its faults, a line each.

    Parameters
    ----------
    directory
        Output directory of a run.
    repair
        Remove a database that cannot be read, so that it is rebuilt from the records.
    """
    path = directory / DATABASE
    if not path.exists():
        return [f"{DATABASE}: is not there; it can be made from the records"]
    try:
        with attach(path) as connection:
            for (table,) in connection.execute("SELECT table_name FROM duckdb_tables()").fetchall():
                connection.execute(f"SELECT max(hash(COLUMNS(*))) FROM results.{table}")
    except (ResultsError, duckdb.Error) as error:
        if repair and path.is_file():
            path.unlink(missing_ok=True)
        return [f"{DATABASE}: {reason(error).removeprefix(f'{path}: ')}"]
    return []
