#!/usr/bin/env python3
"""Measure the engine: what it adds to the physics, what a second worker brings, whether memory stays flat.

Run it with the environment of `./scripts/setup`, on a machine that is otherwise idle:

    .venv/bin/python -m benchmarks.engine_benchmark cases  1,000 cases, with one worker and with two
    .venv/bin/python -m benchmarks.engine_benchmark tasks  10,000 tasks of next to no work

`cases` sweeps 10 soils x 20 speeds x 5 trains and prints the share of the workers' processor time that the
physics has, and the gain by the second worker. `tasks` samples the memory of driver and scheduler, and draws
it to docs/figures/engine-memory.png; it prints what docs/scale.md carries forward. Dask remembers the names
of the last 100,000 tasks: that memory is filled before, so that what is seen is what goes on.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil
from dask.utils import key_split
from distributed import Client

from sweep import plan, study
from sweep.running import scheduler
from sweep.running.task import Place
from sweep.storage import location, records, store
from sweep.wanted import spectra_unit
from sweep.workers import dask_cluster
from sweep.workers.launch import STAGES
from tests.sweep import toy

ROOT = Path(__file__).parents[1]
FIGURE = ROOT / "docs" / "figures" / "engine-memory.png"
ENGINES = {"load", "store"}
"""Stages of a task that are the engine's."""
SAMPLE_S = 0.5


def benchmark_study(speeds: int) -> dict[str, Any]:
    """Return the study: soils from soft to stiff, trains of two vehicles that differ in their bogies."""
    soils = {
        f"soil-{number}": {
            "layers": [
                {
                    "thickness_m": 2.0 + 0.2 * number,
                    "shear_speed_m_s": 140.0 + 10.0 * number,
                    "dilatational_speed_m_s": 300.0 + 25.0 * number,
                    "density_kg_m3": 1800.0,
                    "loss_factor": 0.06,
                },
                {
                    "shear_speed_m_s": 250.0 + 15.0 * number,
                    "dilatational_speed_m_s": 600.0 + 50.0 * number,
                    "density_kg_m3": 2000.0,
                    "loss_factor": 0.04,
                },
            ]
        }
        for number in range(10)
    }
    vehicle = {
        "car_mass_kg": 40e3,
        "car_pitch_inertia_kg_m2": 2e6,
        "bogie_mass_kg": 5e3,
        "bogie_pitch_inertia_kg_m2": 6e3,
        "wheelset_mass_kg": 1800.0,
        "primary_stiffness_n_m": 2.4e6,
        "primary_damping_n_s_m": 3e4,
        "secondary_stiffness_n_m": 6e5,
        "secondary_damping_n_s_m": 2e4,
        "axle_spacing_m": 2.7,
        "length_m": 26.6,
        "axle_load_n": 140.1e3,
        "contact_stiffness_per_wheel_n_m": 1.4625e9,
    }
    vehicles = {
        f"vehicle-{number}": vehicle | {"bogie_spacing_m": 17.0 + 0.5 * number} for number in range(5)
    }
    return {
        "study": {"name": "engine-benchmark"},
        "frequency": {"minimum_hz": 4.0, "maximum_hz": 25.0},
        "receivers": {"rail": True, "offsets_m": [8.0, 16.0]},
        "approaches": {"compare": ["moving-roughness", "full"], "reference": "full"},
        "sweep": {
            "soil": list(soils),
            "track": ["ballasted-paper"],
            "train": [f"train-{number}" for number in range(5)],
            "unevenness": ["fra-hamid-yang-3"],
            "speed_kmh": [60.0 + 10.0 * number for number in range(speeds)],
        },
        "accuracy": {"tolerance": 1e-3},
        "soil": soils,
        "vehicle": vehicles,
        "train": {
            f"train-{number}": {"vehicles": [{"vehicle": f"vehicle-{number}", "number": 2}]}
            for number in range(5)
        },
    }


def run(directory: Path, made: plan.Plan, kinds: str, crew: scheduler.Crew) -> scheduler.Tally:
    """Run a plan, and insist that every task is done."""
    tally = scheduler.run(made, Place(str(directory), "benchmark", kinds), crew, lambda *_: None)
    assert (tally.done, tally.failed) == (tally.total, 0), tally.failures[:3]
    return tally


def cases(folder: Path, speeds: int) -> None:
    """Sweep the 1,000 cases with one worker and with two."""
    began = time.perf_counter()
    resolved = study.resolve(benchmark_study(speeds))
    wanted = [
        spectra_unit(resolved, case, approach)
        for case in resolved.cases()
        for approach in resolved.study.approaches.compare
    ]
    made = plan.make(wanted, set())
    print(f"{len(wanted) // 2} cases, {len(made.tasks)} tasks, {len(made.units)} results")
    print(f"planned in {time.perf_counter() - began:.1f} s")
    walls = {}
    for workers in (1, 2):
        directory = folder / f"{workers}-workers"
        directory.mkdir()
        with dask_cluster.local(workers, STAGES) as crew:
            before = sum(crew.processor_seconds())
            began = time.perf_counter()
            tally = run(directory, made, STAGES, crew)
            walls[workers] = time.perf_counter() - began
            spent = sum(crew.processor_seconds()) - before
        physics = engines = 0.0
        for record in records.committed(directory):
            for stage in record["costs"]:
                nested = stage["stage"] == "wheel-rail forces" and record["inputs"].get("approach") == "full"
                if stage["stage"] in ENGINES:
                    engines += stage["cpu_s"]
                elif not nested:  # in the excitation's time already
                    physics += stage["cpu_s"]
        print(
            f"{workers} workers: {walls[workers]:.1f} s; processor {spent:.1f} s, tasks {tally.cpu_s:.1f} s"
        )
        print(f"  physics {physics / spent:.1%}, storing and loading {engines / spent:.1%}")
        print(
            f"  beside the physics {(spent - physics) / tally.done * 1e3:.2f} ms of processor time per task"
        )
    print(f"two workers are {walls[1] / walls[2]:.2f} times as fast as one")


@contextmanager
def own_scheduler(folder: Path) -> Iterator[tuple[str, psutil.Process]]:
    """Start a scheduler and two workers as processes of their own; yield the address and the scheduler."""
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
    started: list[subprocess.Popen[bytes]] = []
    try:
        for command in commands:
            started.append(subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL))
            while not file.exists():
                time.sleep(0.1)
        yield json.loads(file.read_text())["address"], psutil.Process(started[0].pid)
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()


def remember_names() -> None:
    """Fill what Dask remembers of the names of tasks, in the process that calls this."""
    for number in range(int(key_split.cache_info().maxsize or 0)):
        key_split(f"filled-{number:032x}")


def tasks(folder: Path, number: int) -> None:
    """Run many tasks of next to no work, and watch the memory of who hands them out."""
    wanted = [toy.square(2 * index) for index in range(number)]
    began = time.perf_counter()
    made = plan.make(wanted, set())
    print(f"{number} tasks planned in {time.perf_counter() - began:.1f} s")
    directory = folder / "run"
    directory.mkdir()
    samples: list[tuple[int, float, float]] = []
    stop = threading.Event()
    with (
        own_scheduler(folder) as (address, process),
        dask_cluster.remote(address, None, toy.__name__) as crew,
    ):
        before = process.memory_info().rss
        with Client(address, set_as_default=False) as client:
            client.run_on_scheduler(remember_names)
        taken = (process.memory_info().rss - before) / 2**20
        print(
            f"the scheduler remembers the names of {key_split.cache_info().maxsize} tasks in {taken:.0f} MiB"
        )
        settled = 0

        def watch() -> None:
            while not stop.wait(SAMPLE_S):
                samples.append((settled, psutil.Process().memory_info().rss, process.memory_info().rss))

        def report(task: plan.Task, outcome: Any, tally: scheduler.Tally) -> None:
            nonlocal settled
            settled = tally.settled

        watcher = threading.Thread(target=watch)
        watcher.start()
        used = process.cpu_times()
        mine = time.process_time()
        began = time.perf_counter()
        tally = scheduler.run(made, Place(str(directory), "benchmark", toy.__name__), crew, report)
        wall = time.perf_counter() - began
        mine = time.process_time() - mine
        after = process.cpu_times()
        stop.set()
        watcher.join()
    assert tally.done == number
    scheduling = (after.user + after.system - used.user - used.system) / number
    print(f"{number / wall:.0f} tasks/s; processor time per task:")
    print(f"  driver {1e3 * mine / number:.2f} ms, scheduler {1e3 * scheduling:.2f} ms")
    print(f"  workers {1e3 * tally.cpu_s / number:.2f} ms, storing and recording")
    for name, column in (("driver", 1), ("scheduler", 2)):
        series = [sample[column] / 2**20 for sample in samples]
        half = len(series) // 2
        grown = (max(series[half:]) - max(series[:half])) if half else 0.0
        print(
            f"{name}: {series[0]:.0f} MiB at first, {series[-1]:.0f} at last, {grown:+.1f} from half to half"
        )
    draw(samples)
    cost_of_looking(directory, number)


def draw(samples: list[tuple[int, float, float]]) -> None:
    """Draw memory over settled tasks."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.0, 3.0), layout="constrained")
    for column, name in ((1, "driver"), (2, "scheduler")):
        axes.plot([each[0] for each in samples], [each[column] / 2**20 for each in samples], label=name)
    axes.set(xlabel="tasks settled", ylabel="resident memory [MiB]", ylim=(0.0, None))
    axes.legend(frameon=False)
    figure.savefig(FIGURE, dpi=130)
    print(f"drawn to {FIGURE.relative_to(ROOT)}")


def cost_of_looking(directory: Path, number: int) -> None:
    """Print what it takes to list, read and verify what a run has stored, per result."""
    for what, look in (
        ("names of records", lambda: len(records.present(directory))),
        ("records read", lambda: sum(1 for _ in records.committed(directory))),
        ("groups listed", lambda: len(location.at(directory).names(f"{store.STORE}/square"))),
        (
            "groups verified",
            lambda: sum(1 for each in records.committed(directory) if _sound(directory, each)),
        ),
    ):
        began = time.perf_counter()
        assert look() == number + (what == "groups listed")  # and the metadata of the group above
        print(f"{what}: {1e6 * (time.perf_counter() - began) / number:.0f} us per result")
    files = [path.stat() for path in directory.rglob("*") if path.is_file()]
    taken = sum(each.st_blocks for each in files) * 512
    print(f"files: {len(files) / number:.1f} and {taken / number:.0f} bytes per result")


def _sound(directory: Path, record: dict[str, Any]) -> bool:
    store.check(directory, record)
    return True


def main() -> None:
    """Run one of the benchmarks."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("which", choices=["cases", "tasks"])
    parser.add_argument("--speeds", type=int, default=20, help="of the 1,000 cases' 20: fewer for a try")
    parser.add_argument("--tasks", type=int, default=10_000)
    parser.add_argument("--folder", type=Path, help="where to work; by default a temporary directory")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=given.folder) as folder:
        if given.which == "cases":
            cases(Path(folder), given.speeds)
        else:
            tasks(Path(folder), given.tasks)


if __name__ == "__main__":
    main()
