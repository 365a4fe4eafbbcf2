"""What the engine adds to the physics, and the gain by a second worker, over 1,000 cases.

    .venv/bin/python -m benchmarks.thousand_cases [--speeds 20] [--folder DIR]

sweeps 10 soils x 20 speeds x 5 trains with one worker and with two. It prints the share of the physics in the
workers' CPU time, and the speed-up. Let nothing else run meanwhile.
"""

import tempfile
import time
from pathlib import Path
from typing import Any

import click

from sweep import plan, study
from sweep.running import scheduler
from sweep.running.task import Place
from sweep.storage import records
from sweep.wanted import spectra_unit
from sweep.workers import dask_cluster
from sweep.workers.launch import STAGES

ENGINE_STAGES = {"load", "store"}
"""Stages of a task that belong to the engine."""


def definition(speeds: int) -> dict[str, Any]:
    """Return the study: soils from soft to stiff, trains of two vehicles with different bogies."""
    return {
        "study": {"name": "thousand-cases"},
        "frequency": {"minimum_hz": 4.0, "maximum_hz": 25.0},
        "receivers": {"rail": True, "offsets_m": [8.0, 16.0]},
        "approaches": {"compare": ["moving-roughness", "full"], "reference": "full"},
        "sweep": {
            "soil": [f"soil-{number}" for number in range(10)],
            "track": ["ballasted-paper"],
            "train": [f"train-{number}" for number in range(5)],
            "unevenness": ["fra-hamid-yang-3"],
            "speed_kmh": [60.0 + 10.0 * number for number in range(speeds)],
        },
        "accuracy": {"tolerance": 1e-3},
        "soil": {f"soil-{number}": _soil(number) for number in range(10)},
        "vehicle": {f"vehicle-{number}": _vehicle(number) for number in range(5)},
        "train": {
            f"train-{number}": {"vehicles": [{"vehicle": f"vehicle-{number}", "number": 2}]}
            for number in range(5)
        },
    }


def _soil(number: int) -> dict[str, Any]:
    return {
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


def _vehicle(number: int) -> dict[str, float]:
    return {
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
        "bogie_spacing_m": 17.0 + 0.5 * number,
    }


def sweep_cases(folder: Path, speeds: int) -> None:
    """Run the study with one worker and with two, and print where the CPU time goes."""
    start = time.perf_counter()
    resolved = study.resolve(definition(speeds))
    spectra = [
        spectra_unit(resolved, case, approach)
        for case in resolved.cases()
        for approach in resolved.study.approaches.compare
    ]
    whole = plan.make(spectra, set())
    print(f"{len(spectra) // 2} cases, {len(whole.tasks)} tasks, {len(whole.units)} results")
    print(f"planned in {time.perf_counter() - start:.1f} s")
    walls = [_run(whole, folder / f"{workers}-workers", workers) for workers in (1, 2)]
    print(f"two workers are {walls[0] / walls[1]:.2f} times as fast as one")


def _run(whole: plan.Plan, directory: Path, workers: int) -> float:
    """Run a plan and print the share of physics and engine; return the wall seconds."""
    directory.mkdir()
    with dask_cluster.local(workers, STAGES) as crew:
        before = sum(crew.processor_seconds())
        start = time.perf_counter()
        place = Place(str(directory), "benchmark", STAGES)
        tally = scheduler.run(whole, place, crew, lambda *_: None)
        wall = time.perf_counter() - start
        cpu = sum(crew.processor_seconds()) - before
    assert (tally.done, tally.failed) == (tally.total, 0), tally.failures[:3]
    physics, engine = cpu_by_owner(directory)
    print(f"{workers} workers: {wall:.1f} s; CPU {cpu:.1f} s, tasks {tally.cpu_s:.1f} s")
    print(f"  physics {physics / cpu:.1%}, storing and loading {engine / cpu:.1%}")
    print(f"  beside the physics {(cpu - physics) / tally.done * 1e3:.2f} ms of CPU time per task")
    return wall


def cpu_by_owner(directory: Path) -> tuple[float, float]:
    """Return the CPU seconds of physics and of loading and storing, from the commit records of a run."""
    physics = engine = 0.0
    for record in records.commits(directory):
        for cost in record["costs"]:
            if cost["stage"] in ENGINE_STAGES:
                engine += cost["cpu_s"]
            else:
                physics += cost["cpu_s"]
    return physics, engine


@click.command()
@click.option("--speeds", default=20, show_default=True, help="Fewer for a try.")
@click.option("--folder", type=click.Path(path_type=Path), help="Where to work; default: a temporary one.")
def main(speeds: int, folder: Path | None) -> None:
    """Measure what the engine adds to the physics over 1,000 cases."""
    with tempfile.TemporaryDirectory(dir=folder) as temporary:
        sweep_cases(Path(temporary), speeds)


if __name__ == "__main__":
    main(prog_name="python -m benchmarks.thousand_cases")
