"""Section 3: the paper's study cold, warm and repeated, where its time goes, and whether workers agree."""

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.figures import Figure
from benchmarks.runs import process, sameness
from benchmarks.runs.process import RunCost
from benchmarks.runs.study_text import PAPER_SOILS, study
from benchmarks.sizes import Size

SECTION = "study"
ITEM = "the paper's study"
WARM_S, FIRST_TASK_S, COMPILING_S, PEAK_MB = 6.0, 3.0, 20.0, 600.0
SAME = 1e-12
_CORES = 2


def measure(size: Size) -> Iterator[Figure]:
    """Yield times and memory of the study, in its full or a smaller range."""
    text = study(bands_hz=size.bands_hz, offsets_m=size.offsets_m, soils=PAPER_SOILS)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        environment = {"NUMBA_CACHE_DIR": str(home / "compiled")}
        cold = process.run(text, home / "cold", _CORES, environment)
        warm = [process.run(text, home / f"warm-{i}", _CORES, environment) for i in range(size.runs)]
        again = [process.run(text, home / "warm-0", _CORES, environment) for _ in range(size.runs)]
        alone = process.run(text, home / "alone", 1, environment)
        for case, runs, target in (
            ("cold: empty compile cache", [cold], None),
            ("warm", warm, WARM_S),
            ("asked again", again, None),
            ("warm, 1 worker", [alone], None),
        ):
            yield Figure(SECTION, ITEM, case, "wall", "s", tuple(run.wall_s for run in runs), at_most=target)
            yield Figure(SECTION, ITEM, case, "cpu", "s", tuple(run.cpu_s for run in runs))
        yield from _warm(warm)
        added = cold.wall_s - sorted(run.wall_s for run in warm)[len(warm) // 2]
        yield Figure(SECTION, ITEM, "cold", "compilation adds, wall", "s", (added,), at_most=COMPILING_S)
        difference, arrays = sameness.largest_difference(home / "alone", home / "warm-0")
        yield Figure(SECTION, ITEM, "1 and 2 workers", "arrays compared", "1", (float(arrays),))
        yield Figure(SECTION, ITEM, "1 and 2 workers", "largest difference", "1", (difference,), at_most=SAME)


def _warm(runs: Sequence[RunCost]) -> Iterator[Figure]:
    """Yield the time to the first task, the peak memory, and the CPU seconds by stage, the dearest first."""
    first = tuple(run.first_task_s for run in runs if run.first_task_s is not None)
    yield Figure(SECTION, ITEM, "warm", "until the first task", "s", first, at_most=FIRST_TASK_S)
    peak = tuple(run.peak_bytes / 1e6 for run in runs)
    yield Figure(SECTION, ITEM, "warm", "peak memory of a process", "MB", peak, at_most=PEAK_MB)
    stages = min(runs, key=lambda run: run.wall_s).stages
    for name in sorted(stages, key=stages.__getitem__, reverse=True):
        samples = tuple(run.stages.get(name, 0.0) for run in runs)
        yield Figure(SECTION, "stage", name, "cpu", "s", samples)
    rest = tuple(run.cpu_s - run.computing_s for run in runs)
    yield Figure(SECTION, "stage", "all else: start, engine, database, figures", "cpu", "s", rest)
