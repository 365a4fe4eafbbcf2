"""Whether the memory of driver and scheduler stays flat over many tasks of next to no work.

    .venv/bin/python -m benchmarks.many_tasks [--tasks 10000] [--folder DIR]

prints the CPU time of driver, scheduler and workers per task, the growth of memory, and the cost of listing,
reading and verifying the results, which docs/scale.md carries forward. It draws the memory to
docs/figures/engine-memory.png. Dask remembers the names of the last 100,000 tasks: that memory is filled
before, so that only lasting growth shows. Let nothing else run meanwhile.
"""

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import click
import psutil
from dask.utils import key_split
from distributed import Client

from benchmarks.runs import squares
from sweep import plan
from sweep.running import scheduler
from sweep.running.task import Place
from sweep.storage import location, records, store
from sweep.unit import unit_of
from sweep.workers import dask_cluster

ROOT = Path(__file__).parents[1]
FIGURE = ROOT / "docs" / "figures" / "engine-memory.png"
SAMPLE_S = 0.5


class Sample(NamedTuple):
    """Resident memory, bytes, after a number of settled tasks."""

    settled: int
    driver: int
    scheduler: int


@contextmanager
def separate_scheduler(folder: Path) -> Iterator[tuple[str, psutil.Process]]:
    """Start a scheduler and two workers as separate processes; yield address and process of the scheduler."""
    file = folder / "scheduler.json"
    environment = {
        **os.environ,
        **dask_cluster.ENVIRONMENT,
        "PYTHONPATH": str(ROOT),
        "DASK_DISTRIBUTED__SCHEDULER__WORKER_SATURATION": "1.0",
        "DASK_DISTRIBUTED__SCHEDULER__WORK_STEALING": "False",
        "DASK_DISTRIBUTED__ADMIN__LOW_LEVEL_LOG_LENGTH": "100",
    }
    dask = [sys.executable, "-m", "dask"]
    common = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
    commands = [
        [*dask, "scheduler", "--port", "0", *common],
        [*dask, "worker", "--nworkers", "2", "--nthreads", "1", *common],
    ]
    processes: list[subprocess.Popen[bytes]] = []
    try:
        for command in commands:
            processes.append(subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL))
            while not file.exists():
                time.sleep(0.1)
        yield json.loads(file.read_text())["address"], psutil.Process(processes[0].pid)
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait()


def fill_name_cache() -> None:
    """Fill the cache in which Dask remembers the names of tasks, in the process that calls this."""
    for number in range(int(key_split.cache_info().maxsize or 0)):
        key_split(f"filled-{number:032x}")


def run_tasks(directory: Path, number: int) -> list[Sample]:
    """Run many small tasks, print what each costs, and return samples of memory."""
    start = time.perf_counter()
    whole = plan.make([unit_of(squares.Square(number=float(index))) for index in range(number)], set())
    print(f"{number} tasks planned in {time.perf_counter() - start:.1f} s")
    with (
        tempfile.TemporaryDirectory() as folder,
        separate_scheduler(Path(folder)) as (address, process),
        dask_cluster.remote(address, None, squares.__name__) as crew,
    ):
        before = process.memory_info().rss
        with Client(address, set_as_default=False) as client:
            client.run_on_scheduler(fill_name_cache)
        cache = (process.memory_info().rss - before) / 2**20
        print(f"names of {key_split.cache_info().maxsize} tasks take {cache:.0f} MiB in the scheduler")
        with _watch(process) as (samples, report):
            times = process.cpu_times()
            driver = time.process_time()
            start = time.perf_counter()
            tally = scheduler.run(whole, Place(str(directory), "benchmark", squares.__name__), crew, report)
            wall = time.perf_counter() - start
            driver = time.process_time() - driver
            end = process.cpu_times()
    assert tally.done == number
    scheduling = end.user + end.system - times.user - times.system
    print(f"{number / wall:.0f} tasks/s; CPU time per task:")
    print(f"  driver {1e3 * driver / number:.2f} ms, scheduler {1e3 * scheduling / number:.2f} ms")
    print(f"  workers {1e3 * tally.cpu_s / number:.2f} ms, storing and recording")
    return samples


@contextmanager
def _watch(process: psutil.Process) -> Iterator[tuple[list[Sample], Callable[..., None]]]:
    """Sample the memory of this process and the scheduler; yield the samples and the report of progress."""
    samples: list[Sample] = []
    stop = threading.Event()
    settled = 0

    def sample() -> None:
        while not stop.wait(SAMPLE_S):
            samples.append(Sample(settled, psutil.Process().memory_info().rss, process.memory_info().rss))

    def report(task: plan.Task, outcome: Any, tally: scheduler.Tally) -> None:
        nonlocal settled
        settled = tally.settled

    thread = threading.Thread(target=sample)
    thread.start()
    try:
        yield samples, report
    finally:
        stop.set()
        thread.join()


def print_growth(samples: list[Sample]) -> None:
    """Print the memory of driver and scheduler, and its growth from the first half of the run to the next."""
    half = len(samples) // 2
    for name in ("driver", "scheduler"):
        series = [getattr(sample, name) / 2**20 for sample in samples]
        growth = (max(series[half:]) - max(series[:half])) if half else 0.0
        print(
            f"{name}: {series[0]:.0f} MiB at first, {series[-1]:.0f} at last, {growth:+.1f} from half to half"
        )


def draw(samples: list[Sample]) -> None:
    """Draw memory over settled tasks."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.0, 3.0), layout="constrained")
    for name in ("driver", "scheduler"):
        memory = [getattr(sample, name) / 2**20 for sample in samples]
        axes.plot([sample.settled for sample in samples], memory, label=name)
    axes.set(xlabel="tasks settled", ylabel="resident memory [MiB]", ylim=(0.0, None))
    axes.legend(frameon=False)
    figure.savefig(FIGURE, dpi=130)
    print(f"drawn to {FIGURE.relative_to(ROOT)}")


def print_access_costs(directory: Path, number: int) -> None:
    """Print the cost of listing, reading and verifying what a run has stored, per result."""
    for name, access in (
        ("names of records", lambda: len(records.ids_of(directory))),
        ("records read", lambda: sum(1 for _ in records.commits(directory))),
        ("groups listed", lambda: len(location.at(directory).names(f"{store.STORE}/square"))),
        ("groups verified", lambda: _verify(directory)),
    ):
        start = time.perf_counter()
        count = access()
        seconds = time.perf_counter() - start
        assert count == number + (name == "groups listed")  # and the metadata of the group above
        print(f"{name}: {1e6 * seconds / number:.0f} us per result")
    files = [path.stat() for path in directory.rglob("*") if path.is_file()]
    size = sum(file.st_blocks for file in files) * 512
    print(f"files: {len(files) / number:.1f} and {size / number:.0f} bytes per result")


def _verify(directory: Path) -> int:
    """Check every result of a run; return their number."""
    number = 0
    for record in records.commits(directory):
        store.check(directory, record)
        number += 1
    return number


@click.command()
@click.option("--tasks", default=10_000, show_default=True, help="Number of tasks.")
@click.option("--folder", type=click.Path(path_type=Path), help="Where to work; default: a temporary one.")
def main(tasks: int, folder: Path | None) -> None:
    """Measure the memory of driver and scheduler over many tasks of next to no work."""
    with tempfile.TemporaryDirectory(dir=folder) as temporary:
        directory = Path(temporary) / "run"
        directory.mkdir()
        samples = run_tasks(directory, tasks)
        print_growth(samples)
        draw(samples)
        print_access_costs(directory, tasks)


if __name__ == "__main__":
    main(prog_name="python -m benchmarks.many_tasks")
