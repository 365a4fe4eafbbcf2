#!/usr/bin/env python3
"""Time what people wait for when they ask results: ingest, each shipped question, the report and its opening.

The database has 200 cases, 10^6 one-third octaves and 10^8 narrow-band lines, made up but stored as by a run.
Run it with the environment of `./scripts/setup`:

    .venv/bin/python -m benchmarks.results_benchmark [--cases 200] [--lines 2137] [--folder DIR]
"""

import argparse
import math
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from queries.answers.questions import questions
from queries.database import connection as database
from queries.database.ingest import ingest
from queries.figures.crew import WORKERS, Crew
from queries.report import report
from tests.queries.browser import started
from tests.queries.run_directory import Study

RECEIVERS = (
    *((f"axle-{number}", math.nan) for number in range(1, 17)),
    ("rail", math.nan),
    *(("ground", 4.0 * number) for number in range(22)),
)
ON_LINES = {"strongest-lines", "rms-from-lines"}
OPENINGS = 5


def timed(what: str, work: Callable[[], Any], aim: str = "") -> tuple[Any, float]:
    """Do something, and print how long it took beside what is aimed at."""
    start = time.perf_counter()
    result = work()
    seconds = time.perf_counter() - start
    print(f"{what:48} {seconds:8.2f} s   {aim}", flush=True)
    return result, seconds


def counted(directory: Path) -> tuple[int, int]:
    """Return the rows of one-third octaves and of narrow-band lines."""
    with database.connect(directory) as connection:
        row = connection.execute("SELECT (SELECT count(*) FROM bands), (SELECT count(*) FROM psd_lines)")
        bands, lines = row.fetchone() or (0, 0)
    return bands, lines


def open_page(path: Path, folder: Path) -> None:
    """Print how long the report takes from the request to all figures drawn."""
    with started(folder) as browser:
        took = []
        for _ in range(OPENINGS):
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            start = time.perf_counter()
            page.goto(path.as_uri())
            page.wait_for_selector("html[data-ready=yes]", timeout=120_000)
            took.append(time.perf_counter() - start)
            page.close()
        took.sort()
        print(
            f"{'report opens, all figures drawn':48} {took[len(took) // 2]:8.2f} s   aim: 3 s, median of "
            f"{OPENINGS}"
        )


def main() -> None:
    """Make the database, and time."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--lines", type=int, default=2137, help="lines of each spectrum")
    parser.add_argument("--folder", type=Path, help="where to work; default: a temporary folder")
    given = parser.parse_args()
    folder = Path(tempfile.mkdtemp(dir=given.folder))
    directory = folder / "run"
    soils = tuple(f"soil {number}" for number in range(max(1, given.cases // 20)))
    speeds = tuple(60.0 + 10.0 * number for number in range(min(given.cases, 20)))
    try:
        timed(
            "made up records and store",
            lambda: Study(directory, RECEIVERS).write(soils, speeds, lines=given.lines),
        )
        _, seconds = timed("ingest", lambda: ingest(directory))
        bands, lines = counted(directory)
        size = (directory / database.DATABASE).stat().st_size / 1e6
        print(f"{bands:,} bands, {lines:,} lines, database of {size:,.0f} MB")
        print(f"{'ingest rate':48} {(bands + lines) / seconds:8,.0f} rows/s   aim: 200,000")
        timed("ingest of what is there already", lambda: ingest(directory))
        for name, question in questions().items():
            aim = "aim: 5 s" if name in ON_LINES else "aim: 1 s"
            with database.connect(directory) as connection:
                timed(
                    f"question {name}",
                    lambda connection=connection, question=question: connection.execute(  # type: ignore[misc]
                        question.sql, question.values({})
                    ).fetchall(),
                    aim,
                )
        path = directory / "report.html"
        with database.connect(directory) as connection:
            timed("report", lambda: report.write(connection, path))
        print(f"{'size of the report':48} {path.stat().st_size / 1e6:8.1f} MB  aim: 15 MB")
        with Crew(WORKERS) as crew:
            timed("figures", lambda: crew.start(directory / database.DATABASE, folder / "figures")())
        open_page(path, folder / "browser")
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
