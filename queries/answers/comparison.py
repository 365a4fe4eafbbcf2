"""Pairs of levels to compare: two approaches, or two runs."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import duckdb

from queries.answers.approaches import reference, requested_approaches
from queries.statements import statements

_SQL = statements("queries.answers", "comparison")
CASE_NAMES = ("soil", "track", "train", "unevenness", "speed_kmh", "approach")
_NAMES = (*CASE_NAMES, "contribution", "quantity", "receiver", "averaging", "band_hz")
"""Columns by which rows of two runs are matched, beside offsets, which may be NULL."""


@dataclass(frozen=True)
class Pair:
    """A pair of sets of levels: the first is compared with the second.

    Attributes
    ----------
    title
        Names both.
    sign
        States which is subtracted from which.
    rows
        SQL of rows with the columns of the macro `compare`.
    parameters
        Values of its parameters by name.
    approach
        The approach that is compared; None for two runs, whose rows have a column for it.
    """

    title: str
    sign: str
    rows: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    approach: str | None = None

    @staticmethod
    def of_approaches(approach: str, against: str) -> "Pair":
        """Return the pair of two approaches in the newest run of each case."""
        return Pair(
            f"Error of {approach} against {against}",
            f"Level of {approach} minus level of {against}",
            "FROM compare($approach, $against)",
            {"approach": approach, "against": against},
            approach,
        )

    @staticmethod
    def of_runs(first: "Levels", second: "Levels") -> "Pair":
        """Return the pair of two runs, matched by the names of cases and approaches."""
        rows = _SQL["two-runs"].format(
            columns=", ".join(f"first.{name}" for name in (*_NAMES, "offset_m")),
            first=first.relation("levels"),
            second=second.relation("levels"),
            same=" AND ".join(f"first.{name} = second.{name}" for name in _NAMES),
        )
        return Pair(
            f"{first.title} against {second.title}",
            f"Level of {first.title} minus level of {second.title}, for cases and approaches of the same "
            "names",
            rows,
            {**first.parameters, **second.parameters},
        )

    def materialize(self, connection: duckdb.DuckDBPyConnection) -> "Pair":
        """Return the pair with its rows in a temporary table, so that they are computed once."""
        text = json.dumps([self.rows, dict(self.parameters)])
        table = f"pair_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
        exists = "SELECT 1 FROM duckdb_tables() WHERE temporary AND table_name = $1"
        if connection.execute(exists, [table]).fetchone() is None:  # IF NOT EXISTS would plan the rows first
            connection.execute(f"CREATE TEMP TABLE {table} AS {self.rows}", dict(self.parameters))
        return replace(self, rows=f"FROM {table}", parameters={})


@dataclass(frozen=True)
class Levels:
    """Levels of one run, or of the newest run of each case where none is named.

    Attributes
    ----------
    title
        How they are called.
    prefix
        Of the database they lie in: nothing, or "other.".
    run_id
        The run.
    """

    title: str
    prefix: str = ""
    run_id: str | None = None

    @property
    def parameters(self) -> dict[str, str]:
        """Values of the parameters of `relation`, by name."""
        return {} if self.run_id is None else {self._parameter: self.run_id}

    @property
    def _parameter(self) -> str:
        return "run_" + hashlib.sha256(f"{self.prefix}{self.run_id}".encode()).hexdigest()[:8]

    def relation(self, view: str) -> str:
        """Return the SQL of the rows that a view has of this run."""
        if self.run_id is None:
            return f"{self.prefix}{view}"
        return f"(FROM {self.prefix}run_{view} WHERE run_id = ${self._parameter})"


def pairs(connection: duckdb.DuckDBPyConnection) -> list[Pair]:
    """Return the pair of every approach with the reference of the study."""
    against = reference(connection)
    others = (name for name in requested_approaches(connection) if name != against)
    return [Pair.of_approaches(name, against).materialize(connection) for name in others]
