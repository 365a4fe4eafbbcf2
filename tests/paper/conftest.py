"""The paper's study, run as a user runs it."""

import subprocess
import sys
from pathlib import Path

import pytest

import queries

STUDY = Path(__file__).parents[2] / "studies" / "paper.toml"


@pytest.fixture(scope="session")
def run_directory(tmp_path_factory) -> Path:
    """Return the directory of a finished run of the paper's study."""
    directory = tmp_path_factory.mktemp("paper") / "run"
    command = [
        sys.executable,
        "-c",
        "from railvib.cli import main; main()",
        "run",
        str(STUDY),
        "--out",
        str(directory),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return directory


@pytest.fixture(scope="session")
def results(run_directory) -> queries.Results:
    """Return the results database of the run."""
    return queries.open(run_directory)


@pytest.fixture(scope="session")
def levels(results):
    """Return a function from soil, approach and receiver to levels, dB, from 1 to 100 Hz."""
    frame = results.levels
    frame = frame[(frame.contribution == "dynamic") & (frame.averaging == "line")]

    def select(soil: str, approach: str, receiver: str, offset: float | None = None):
        rows = frame[(frame.soil == soil) & (frame.approach == approach) & (frame.receiver == receiver)]
        rows = rows if offset is None else rows[rows.offset_m == offset]
        rows = rows.sort_values("band_hz")
        assert len(rows) == 21
        return rows.set_index(rows.band_hz.round(2)).level_db

    return select
