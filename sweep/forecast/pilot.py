"""Rates at which this machine works: measured once on a small study, and kept for later plans.

The pilot runs tasks of the product itself in a process set up as a worker, and finds for each sort of task
the rates at which its processor time follows its amounts of work (`railvib.stages.Work`), by least squares
with rates that are not negative. They are kept in the user's cache directory, by host, model version,
libraries and the code of the physics, as all of these change them.
"""

import hashlib
import json
import multiprocessing
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from importlib import metadata, resources
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from railvib import library
from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.cross_section import CrossSection
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import RAIL, Receiver
from railvib.stages import Work
from railvib.stages.fe_be_table import FeBeTable
from railvib.stages.train_integrals import ReceiverTrainIntegrals
from railvib.stages.transfer_table import TransferTable
from sweep import plan, study
from sweep.host import host_class
from sweep.processes import compiling, forks, parent
from sweep.running.task import Place, execute
from sweep.storage import records
from sweep.unit import Unit, unit_of, work
from sweep.wanted import wanted_units
from sweep.workers.launch import STAGES

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite")
_PLACES = 120
MANY_OFFSETS = [6.0 * number for number in range(1, 12)]
"""m; what each of many receivers takes is far less than what few of them take together."""


@dataclass(frozen=True)
class Rates:
    """Rates that a pilot measured.

    Attributes
    ----------
    cpu_s
        Processor seconds per unit of each amount, by sort of task.
    idle_bytes
        Resident memory of a worker that has loaded everything and holds nothing.
    pilot_s
        Processor seconds that the pilot took.
    """

    cpu_s: Mapping[str, Mapping[str, float]]
    idle_bytes: int
    pilot_s: float

    def of(self, work: Work) -> float:
        """Return the processor seconds that some work takes."""
        rates = self.cpu_s.get(work.sort, {})
        return sum(rates.get(name, 0.0) * amount for name, amount in work.amounts.items())


@cache
def rates(finite_elements: bool = False) -> Rates:
    """Return this machine's rates, measured now if they have not been; on demand with the FE/BE model's."""
    basic = _load_or_measure("pilot")
    if not finite_elements:
        return basic
    fe_be = _load_or_measure("pilot-fe-be")
    return Rates({**basic.cpu_s, **fe_be.cpu_s}, basic.idle_bytes, basic.pilot_s + fe_be.pilot_s)


def _load_or_measure(name: str) -> Rates:
    """Return the rates of one of the pilots that are kept, or measure and keep them."""
    key = f"{name}-{_key()}.json"
    with suppress(OSError, RuntimeError, ValueError, TypeError):
        return Rates(**json.loads((cache_folder() / key).read_bytes()))
    measured = _measure_apart(name)
    with suppress(OSError, RuntimeError):  # an unwritable cache counts as absent
        path = cache_folder() / key
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_suffix(f".{os.getpid()}.partial")
        temporary.write_text(json.dumps(asdict(measured)), encoding="utf-8")
        temporary.replace(path)
    return measured


def cache_folder() -> Path:
    """Return the user's cache folder.

    Raises
    ------
    RuntimeError
        If the user has no home.
    """
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "railvib"


def _key() -> str:
    """Return the digest of all that rates depend on."""
    digest = hashlib.sha256()
    for text in (socket.gethostname(), host_class(), sys.version, *map(metadata.version, LIBRARIES)):
        digest.update(text.encode() + b"\0")
    sources = [Path(str(resources.files(package))) for package in ("railvib", "sweep.forecast")]
    for file in sorted(file for folder in sources for file in folder.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:32]


def _measure_apart(name: str) -> Rates:
    """Measure in a separate process like a worker: forked, or started in a worker's environment."""
    if forks.running():
        measured: Rates = forks.submit(PILOTS[name])()
        return measured
    from sweep.workers.dask_cluster import ENVIRONMENT

    variables = {**ENVIRONMENT, forks.STAGES_MODULE: STAGES, forks.DRIVER: str(os.getpid())}
    command = [sys.executable, "-m", "sweep.forecast.pilot", name]
    with forks.block_signals():
        process = subprocess.Popen(command, env={**os.environ, **variables}, stdout=subprocess.PIPE)
    try:
        output, _ = process.communicate()
    except BaseException:
        process.kill()
        process.wait()
        raise
    if process.returncode:
        raise RuntimeError(f"the pilot failed with exit status {process.returncode}")
    return Rates(**json.loads(output))


def measure() -> Rates:
    """Run the pilot's tasks in this process, and return the rates."""
    import sweep.workers.preloaded  # noqa: F401 - what a worker has loaded

    compiling.load(STAGES)  # a process that serves runs of other stages may have been forked
    idle = _resident()
    began = time.process_time()
    samples: dict[str, list[_Sample]] = {}
    with tempfile.TemporaryDirectory(prefix="railvib-pilot-") as folder:
        place = Place(folder, "pilot", STAGES)
        for task in _tasks():
            sample = _time_task(task, place)
            samples.setdefault(sample.work.sort, []).append(sample)
    return Rates(
        {sort: _rates(of_sort) for sort, of_sort in samples.items()}, idle, time.process_time() - began
    )


def _resident() -> int:
    """Return the resident memory of this process; of a forked one, with the shared part not yet touched."""
    import psutil

    this = psutil.Process()
    forked_from = this.parent() if multiprocessing.parent_process() else None
    processes = [this] if forked_from is None else [this, forked_from]
    return max(int(process.memory_info().rss) for process in processes)


def measure_fe_be() -> Rates:
    """Evaluate the FE/BE model at some places, and return what one place costs."""
    from railvib.fe_be.model import FeBeModel
    from railvib.soil.fits import GroundFits

    compiling.compile_stage(FeBeTable)
    began = time.process_time()
    ground, track = library.load("soil", "greby"), library.load("track", "ballasted-paper")
    block, tolerance = 2, 1e-3
    model = FeBeModel(ground, track, CrossSection(), block)
    evaluate = model(GroundFits(ground, block, 1e-6 * tolerance), track, [8.0], tolerance)
    beta = np.linspace(0.01, 6.0, _PLACES)
    ks = blocks.indices(block, 0)
    evaluate(0, int(ks[0]), beta)  # builds what is kept per block
    spent = time.process_time()
    for k in ks[1:4]:
        evaluate(0, int(k), beta)
    spent = time.process_time() - spent
    return Rates({FeBeTable.SORT: {"values": spent / (3 * _PLACES)}}, 0, time.process_time() - began)


class _Sample(NamedTuple):
    """A task's work, and the processor seconds that it took: altogether and by stage."""

    work: Work
    total: float
    stages: Mapping[str, float]


def _time_task(task: Sequence[Unit], place: Place) -> _Sample:
    """Run a task as a worker does, with all that goes into storing it."""
    outcome = execute("pilot", task, place)
    if outcome.status != "done":
        raise RuntimeError(f"the pilot failed: {outcome.error}")
    stages: dict[str, float] = {}
    for unit in task:
        record = records.find(place.directory, unit.stage_name, unit.id)
        for spent in record["costs"] if record else ():
            stages[spent["stage"]] = stages.get(spent["stage"], 0.0) + spent["cpu_s"]
    return _Sample(work(task), outcome.cpu_s, stages)


def _tasks() -> list[tuple[Unit, ...]]:
    """Return tasks of small studies: two grounds, trains of 4 to 16 axles, near and far receivers."""
    tasks_by_key: dict[str, tuple[Unit, ...]] = {}
    for soil, train, offsets, band, averaging in (
        ("horstwalde", "short", [8.0], (10.0, 12.5), ["line", "train"]),
        ("horstwalde", "medium", [], (10.0, 12.5), ["line", "train"]),
        ("horstwalde", "long", [8.0], (10.0, 12.5), ["line"]),
        ("greby", "long", MANY_OFFSETS, (8.0, 16.0), ["line"]),
    ):
        resolved = study.resolve(_study(soil, train, offsets, band, averaging))
        (case,) = resolved.cases()
        wanted = [
            unit
            for approach in resolved.study.approaches.compare
            for unit in wanted_units(resolved, case, approach)
        ]
        for key, task in plan.make(wanted, set()).tasks.items():
            # Averages over the train need trains of two lengths; a long one would take seconds.
            if train != "medium" or isinstance(task.units[0].stage, ReceiverTrainIntegrals):
                tasks_by_key.setdefault(key, task.units)
    layered = _split(library.load("soil", "greby"))
    track = library.load("track", "ballasted-paper")
    for block in (0, 2):
        tasks_by_key[f"{block}"] = tuple(
            unit_of(
                TransferTable(ground=layered, track=track, tolerance=1e-4, receiver=receiver, block=block)
            )
            for receiver in (RAIL, Receiver(32.0))
        )
    return list(tasks_by_key.values())


def _study(
    soil: str, train: str, offsets: list[float], band: tuple[float, float], averaging: list[str]
) -> dict[str, Any]:
    return {
        "study": {"name": "pilot"},
        "frequency": {"minimum_hz": band[0], "maximum_hz": band[1]},
        "receivers": {"rail": True, "offsets_m": offsets},
        "approaches": {
            "compare": ["moving-roughness", "full"],
            "reference": "full",
            "averaging": averaging,
        },
        "levels": {"metrics": ["kb-f-max", "ppv"], "passages": 64},
        "sweep": {
            "soil": [soil],
            "track": ["ballasted-paper"],
            "train": [train],
            "unevenness": ["german-low"],
            "speed_kmh": [60.0],
        },
        "train": {
            "short": {"vehicle": "regina"},
            "medium": {"vehicles": [{"vehicle": "regina", "number": 2}]},
            "long": {"vehicles": [{"vehicle": "regina", "number": 4}]},
        },
    }


def _split(ground: Any) -> Ground:
    """Return a ground with each layer split in two: the same physics, and twice the work."""
    halves = [
        layer.model_copy(update={"thickness": layer.thickness / 2.0})
        for layer in ground.layers[:-1]
        for _ in range(2)
    ]
    return Ground(layers=(*halves, ground.layers[-1]))


def _rates(samples: Sequence[_Sample]) -> dict[str, float]:
    """Return the rates of a sort of task: some amounts make a stage, the others all the rest."""
    stages = samples[0].work.by_cost
    staged = {name for names in stages.values() for name in names}
    rest = [name for name in samples[0].work.amounts if name not in staged]
    by_name: dict[str, float] = {}
    for stage, names in stages.items():
        by_name |= _fit_rates(names, samples, [sample.stages.get(stage, 0.0) for sample in samples])
    others = [sample.total - sum(sample.stages.get(stage, 0.0) for stage in stages) for sample in samples]
    return by_name | _fit_rates(rest, samples, others)


def _fit_rates(names: Sequence[str], samples: Sequence[_Sample], spent: Sequence[float]) -> dict[str, float]:
    """Fit non-negative rates to the times of tasks; short tasks weigh as much as long ones."""
    from scipy.optimize import nnls  # slow to import, and a pilot is rare

    amounts = np.array([[sample.work.amounts[name] for name in names] for sample in samples])
    weight = 1.0 / np.maximum(spent, 0.1 * np.max(spent) + 1e-4)
    scale = amounts.max(axis=0)
    solution, _ = nnls(amounts / scale * weight[:, None], np.asarray(spent) * weight)
    return dict(zip(names, (solution / scale).tolist(), strict=True))


PILOTS = {"pilot": measure, "pilot-fe-be": measure_fe_be}
"""Functions that measure rates, by the name under which these are kept."""

if __name__ == "__main__":
    parent.end_with(int(os.environ.get(forks.DRIVER, os.getppid())))
    print(json.dumps(asdict(PILOTS[sys.argv[1]]())))
