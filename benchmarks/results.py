"""Response times of the results: ingest, each shipped question, the report, the figures, and the page.

    .venv/bin/python -m benchmarks.results [--cases 200] [--lines 2137] [--folder DIR]

The database has 200 cases, 10^6 one-third octaves and 10^8 narrow-band lines; their values are invented, and
stored as by a run.
"""

import math
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click
import duckdb

from benchmarks.browser import start_browser
from benchmarks.runs.invented import Study
from queries.answers import Question, questions
from queries.database import DATABASE, connect, ingest
from queries.figures import WORKERS, FigureProcesses
from queries.report import write_report

RECEIVERS = (
    *((f"axle-{number}", math.nan) for number in range(1, 17)),
    ("rail", math.nan),
    *(("ground", 4.0 * number) for number in range(22)),
)
ON_LINES = {"strongest-lines", "rms-from-lines"}
"""Questions about narrow-band lines."""
OPENINGS = 5


def time_step(name: str, step: Callable[[], Any], target: str = "") -> float:
    """Run a step, and print its wall seconds beside the target; return them."""
    start = time.perf_counter()
    step()
    seconds = time.perf_counter() - start
    print(f"{name:48} {seconds:8.2f} s   {target}", flush=True)
    return seconds


def row_counts(directory: Path) -> tuple[int, int]:
    """Return the number of one-third octaves and of narrow-band lines."""
    with connect(directory) as connection:
        row = connection.execute("SELECT (SELECT count(*) FROM bands), (SELECT count(*) FROM psd_lines)")
        bands, lines = row.fetchone() or (0, 0)
    return bands, lines


def time_ingest(directory: Path) -> None:
    """Time ingesting a run, and ingesting it again."""
    seconds = time_step("ingest", lambda: ingest(directory))
    bands, lines = row_counts(directory)
    size = (directory / DATABASE).stat().st_size / 1e6
    print(f"{bands:,} bands, {lines:,} lines, database of {size:,.0f} MB")
    print(f"{'ingest rate':48} {(bands + lines) / seconds:8,.0f} rows/s   target: 200,000")
    time_step("ingest again", lambda: ingest(directory))


def time_questions(directory: Path) -> None:
    """Time each shipped question on a fresh connection."""
    for name, question in questions().items():
        target = "target: 5 s" if name in ON_LINES else "target: 1 s"
        with connect(directory) as connection:
            time_step(f"question {name}", partial(_answer, connection, question), target)


def _answer(connection: duckdb.DuckDBPyConnection, question: Question) -> None:
    connection.execute(question.sql, question.values({})).fetchall()


def time_page(path: Path, folder: Path) -> None:
    """Print the median time from opening the report to all figures drawn, in a browser."""
    with start_browser(folder) as browser:
        seconds = []
        for _ in range(OPENINGS):
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            start = time.perf_counter()
            page.goto(path.as_uri())
            page.wait_for_selector("html[data-ready=yes]", timeout=120_000)
            seconds.append(time.perf_counter() - start)
            page.close()
    median = sorted(seconds)[OPENINGS // 2]
    print(f"{'report opens, all figures drawn':48} {median:8.2f} s   target: 3 s, median of {OPENINGS}")


@click.command()
@click.option("--cases", default=200, show_default=True, help="Number of cases.")
@click.option("--lines", default=2137, show_default=True, help="Lines of each spectrum.")
@click.option("--folder", type=click.Path(path_type=Path), help="Where to work; default: a temporary one.")
def main(cases: int, lines: int, folder: Path | None) -> None:
    """Measure the response times of the results on an invented run."""
    soils = tuple(f"soil {number}" for number in range(max(1, cases // 20)))
    speeds = tuple(60.0 + 10.0 * number for number in range(min(cases, 20)))
    with tempfile.TemporaryDirectory(dir=folder) as temporary:
        directory = Path(temporary) / "run"
        study = Study(directory, RECEIVERS)
        time_step("invented records and store", lambda: study.write(soils=soils, speeds=speeds, lines=lines))
        time_ingest(directory)
        time_questions(directory)
        path = directory / "report.html"
        with connect(directory) as connection:
            time_step("report", lambda: write_report(connection, path))
        print(f"{'size of the report':48} {path.stat().st_size / 1e6:8.1f} MB  target: 15 MB")
        with FigureProcesses(WORKERS) as processes, connect(directory) as connection:
            figures = Path(temporary) / "figures"
            time_step("figures", lambda: processes.start(connection, directory / DATABASE, figures)())
        time_page(path, Path(temporary) / "browser")


if __name__ == "__main__":
    main(prog_name="python -m benchmarks.results")
