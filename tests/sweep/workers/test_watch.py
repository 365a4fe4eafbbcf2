"""A run without workers: what it says, and when it ends."""

import pytest

from sweep.workers import watch


@pytest.fixture
def clock(monkeypatch):
    now = [1000.0]
    monkeypatch.setattr(watch.time, "monotonic", lambda: now[0])
    return now


def test_a_run_that_waits_says_so_and_ends(clock, capsys):
    crew = watch.Watch("workers at tcp://head:8786", 20.0)
    crew.see(3)
    clock[0] += 3600.0  # busy ones do not count as gone
    for _ in range(1199):
        crew.see(0)
        clock[0] += 1.0
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == ("waiting for workers at tcp://head:8786, for 30 s so far; the run ends after 20 min")
    assert len(lines) == 2  # and once in ten minutes
    clock[0] += 1.0
    with pytest.raises(watch.WorkersLostError, match="none for 20 min, the limit set by --wait"):
        crew.see(0)


def test_workers_that_come_back_begin_the_time_anew(clock, capsys):
    crew = watch.Watch("workers", 1.0)
    for _ in range(10):
        crew.see(0)
        clock[0] += 50.0
        crew.see(1)
    assert capsys.readouterr().err == ""


def test_without_limit_it_waits(clock):
    crew = watch.Watch("the first worker of kind slurm", None)
    crew.see(0)
    clock[0] += 1e6
    crew.see(0)
