"""The results of runs: a database derived from their records, comparisons, figures and a report."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas

    from queries.publisher import Publisher


class Results:
    """Published results, for a notebook; every answer is a pandas DataFrame."""

    def __init__(self, named: Path | str) -> None:
        from queries.database import connection

        self._connection = connection.connect(named)

    def __enter__(self) -> "Results":
        """Return itself; leaving the block closes the database."""
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def sql(self, statement: str, parameters: tuple[Any, ...] = ()) -> "pandas.DataFrame":
        """Return the answer to one read-only statement."""
        from queries.answers.sql import query

        return query(self._connection, statement, parameters).fetchdf()

    def ask(self, name: str, folder: Path | str | None = None, **parameters: Any) -> "pandas.DataFrame":
        """Return the answer to a named question; see `railvib queries`."""
        from queries.answers.questions import question
        from queries.answers.sql import query

        asked = question(name, None if folder is None else Path(folder))
        values = asked.values({key: str(value) for key, value in parameters.items()})
        return query(self._connection, asked.sql, values).fetchdf()

    @property
    def cases(self) -> "pandas.DataFrame":
        """Cases with the physical parameters by which they can be grouped, SI units."""
        return self.sql("FROM case_parameters")

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

    @property
    def tradeoff(self) -> "pandas.DataFrame":
        """Error of each case and approach beside its cost."""
        return self.sql("FROM tradeoff")

    def close(self) -> None:
        """Close the database."""
        self._connection.close()


def open(named: Path | str) -> Results:
    """Return the published results of a run directory or a database file.

    Raises
    ------
    queries.database.connection.ResultsError
        If there are none.
    """
    return Results(named)


def after_run(directory: Path | str) -> "Publisher":
    """Return the publishers of a run directory."""
    from queries.publisher import Publisher

    return Publisher(directory)
