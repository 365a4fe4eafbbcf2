"""The results of a run: a database derived from its records, comparisons, figures and a report."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas


class Results:
    """The published results of a run directory, for a notebook; every answer is a pandas DataFrame."""

    def __init__(self, directory: Path | str) -> None:
        from queries import database

        self._connection = database.connect(directory)

    def sql(self, statement: str, parameters: tuple[Any, ...] = ()) -> "pandas.DataFrame":
        """Return the answer to one statement that reads."""
        from queries.sql import query

        return query(self._connection, statement, parameters).fetchdf()

    @property
    def levels(self) -> "pandas.DataFrame":
        """Levels in one-third octaves, dB re 1e-9 m/s for velocity and re 1 N for force."""
        return self.sql("FROM levels")

    @property
    def accuracy(self) -> "pandas.DataFrame":
        """Error of each approach against the reference of the study, dB."""
        return self.sql("FROM accuracy")

    @property
    def runtime(self) -> "pandas.DataFrame":
        """Cost of each case and approach."""
        return self.sql("FROM runtime")

    def close(self) -> None:
        """Let go of the database."""
        self._connection.close()


def open(directory: Path | str) -> Results:
    """Return the published results of a run directory.

    Raises
    ------
    queries.database.ResultsError
        If the directory holds none.
    """
    return Results(directory)


def after_run(directory: Path | str) -> None:
    """Publish the results of a run that has just ended and print them, see `queries.publication`."""
    from queries.publication import after_run as publish_and_print

    publish_and_print(Path(directory))
