"""Run directories for the tests of the results."""

import pytest

from queries import database
from queries.ingest import ingest
from tests.queries.run_directory import Study


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
    with database.connect(paper) as connection:
        yield connection
