"""Run directories for the tests of the results."""

import shutil

import pytest

from benchmarks.runs.invented import Study
from queries import figures
from queries.database import connect, ingest, schema


@pytest.fixture(scope="session")
def empty(tmp_path_factory):
    """Return an empty database, made once: its hundreds of statements take longer than a test's rows."""
    path = tmp_path_factory.mktemp("empty") / "empty.duckdb"
    schema.create(path).close()
    return path


@pytest.fixture(autouse=True)
def _quick_creation(empty, monkeypatch):
    def create(path):
        shutil.copyfile(empty, path)
        return schema.open_for_writing(path)

    monkeypatch.setattr(schema, "create", create)
    monkeypatch.setattr(figures, "WORKERS", 0)


@pytest.fixture
def study(tmp_path):
    """Return a builder of run directories under a path that needs quoting."""
    return Study(tmp_path / "it's a run")


@pytest.fixture(scope="session")
def paper(tmp_path_factory):
    """Return the run directory of the plain study with its database, for tests that only read."""
    directory = Study(tmp_path_factory.mktemp("run") / "paper").write()
    ingest(directory)
    return directory


@pytest.fixture
def results(paper):
    """Return a connection to the results of the plain study."""
    with connect(paper) as connection:
        yield connection
