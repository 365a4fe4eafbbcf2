"""The place of results: the database of a run directory, or one file of many runs."""

from dataclasses import dataclass
from pathlib import Path

DATABASE = "results.duckdb"
_MANIFEST = "run.json"
_SPECIAL = "?\\"
"""Characters that DuckDB does not take literally in an absolute path."""


class ResultsError(Exception):
    """A request about results that cannot be met; its message is one line."""


@dataclass(frozen=True)
class Place:
    """The place of results: a database file, with its figures and report beside it.

    Attributes
    ----------
    named
        As the user calls it.
    path
        The database file.
    directory
        The run directory that the database belongs to; None for a file of its own.
    """

    named: Path
    path: Path
    directory: Path | None

    @property
    def figures(self) -> Path:
        """Folder of the figures."""
        return self._beside("figures", "-figures")

    @property
    def report(self) -> Path:
        """File of the report."""
        return self._beside("report.html", ".html")

    def _beside(self, within: str, ending: str) -> Path:
        return self.directory / within if self.directory else self.path.with_name(self.path.stem + ending)


def locate(named: Path | str) -> Place:
    """Return the place of results that a user names: a run directory or a database file.

    Raises
    ------
    ResultsError
        If it is neither.
    """
    named = Path(named)
    if named.is_file():
        return Place(named, named, None)
    check_run(named)
    return Place(named, named / DATABASE, named)


def check_run(directory: Path | str) -> None:
    """Check that a directory is the output directory of a run.

    Raises
    ------
    ResultsError
        If the directory is missing or holds no run.
    """
    if not Path(directory).is_dir():
        raise ResultsError(f"{directory}: no such directory or database file")
    if not (Path(directory) / _MANIFEST).is_file():
        raise ResultsError(f"{directory}: is not the output directory of a run, it holds no {_MANIFEST}")


def duckdb_path(path: Path) -> str:
    """Return a path in a form that DuckDB takes as a file name and nothing else.

    Raises
    ------
    ResultsError
        If there is no such form, or a folder has the file's name.
    """
    absolute = str(path.absolute())
    special = next((character for character in _SPECIAL if character in absolute), None)
    if special is not None:
        raise ResultsError(f"{path}: DuckDB cannot open a path with '{special}'; rename the folder or file")
    try:
        absolute.encode()
    except UnicodeEncodeError:
        raise ResultsError(f"{str(path)!a}: the name is not text in UTF-8, which DuckDB needs") from None
    if path.is_dir():
        raise ResultsError(f"{path}: is a folder where a database file should be; move it away")
    return absolute


def quote(path: str) -> str:
    """Return a path as a string of SQL."""
    return "'" + path.replace("'", "''") + "'"


def reason(error: Exception) -> str:
    """Return why something failed, in one line."""
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return next(iter(text.splitlines()), type(error).__name__)
