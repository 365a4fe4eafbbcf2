"""Processes that draw figures: they draw what one would draw, and end as they should."""

import signal
import subprocess
import sys

import psutil
import pytest

from queries.database import DATABASE, ResultsError, connect, ingest
from queries.figures import FigureProcesses, processes

WAITING = """
import signal, sys
from queries.figures import FigureProcesses
with FigureProcesses(2) as processes:
    for future in [processes._pool.submit(int) for _ in range(4)]:
        future.result()
    print("ready", flush=True)
    signal.pause()
"""


def waiting():
    """Return a program whose processes wait for figures, and these processes."""
    program = subprocess.Popen(
        [sys.executable, "-c", WAITING],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert program.stdout.readline() == "ready\n"
    family = psutil.Process(program.pid).children(recursive=True)
    assert len(family) >= 2
    return program, family


def alive(family):
    _, left = psutil.wait_procs(family, timeout=30)
    return [process for process in left if process.status() != psutil.STATUS_ZOMBIE]


@pytest.mark.slow
def test_figures_that_several_processes_draw_are_the_same(study):
    directory = study.write(lines=50)
    ingest(directory)
    pictures = []
    for workers, name in ((0, "alone"), (2, "together")):
        with FigureProcesses(workers) as drawing, connect(directory) as connection:
            files = drawing.start(connection, directory / DATABASE, directory / name)()
        pictures.append({path.name: path.read_bytes() for path in files})
    assert pictures[0] == pictures[1]


@pytest.mark.slow
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_they_end_with_the_process_that_they_draw_for(end):
    program, family = waiting()
    with program:
        program.send_signal(end)
        program.wait(30)
    assert alive(family) == []


@pytest.mark.slow
def test_an_interrupt_is_left_to_the_process_that_they_draw_for():
    program, family = waiting()
    with program:
        for process in [*family, psutil.Process(program.pid)]:  # as Ctrl-C reaches all of a terminal
            process.send_signal(signal.SIGINT)
        _, errors = program.communicate(timeout=30)
    assert alive(family) == []
    assert errors.count("Traceback") == 1  # its own
    assert errors.rstrip().endswith("KeyboardInterrupt")


@pytest.mark.slow
def test_one_that_is_killed_is_an_error_of_one_line(study):
    directory = study.write(soils=("clay",), lines=20)
    ingest(directory)
    with FigureProcesses(2) as drawing, connect(directory) as connection:
        pool = drawing._pool
        pool.submit(int).result()
        for process in list(pool._processes.values()):
            process.kill()
        with pytest.raises(ResultsError, match="exited unexpectedly"):
            drawing.start(connection, directory / DATABASE, directory / "figures")()


def test_figures_of_another_snapshot_are_planned_anew(study):
    directory = study.write(soils=("clay",), lines=20)
    ingest(directory)
    path = directory / DATABASE
    first = processes._Request(path, path.stat().st_mtime_ns, directory, "png", False)
    assert "figure-05-receptance-sand" not in processes._drawings(first)
    ingest(study.write(soils=("clay", "sand"), run_id="run-2", started="2026-03-02T08:00:00+00:00", lines=20))
    second = first._replace(written_ns=path.stat().st_mtime_ns)
    assert "figure-05-receptance-sand" in processes._drawings(second)
