"""Studies run as a user runs them, in processes of their own: seconds, memory, and where both went."""

import contextlib
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import psutil

from railvib.errors import InputError
from sweep.storage import records

_INTERVAL_S = 0.1
"""Between two looks at the processes of a run."""


@dataclass(frozen=True)
class RunCost:
    """What one run took.

    Attributes
    ----------
    directory
        Its output directory.
    wall_s, cpu_s
        From the start of the process to its end; CPU seconds of it and all its children.
    first_task_s
        From the start of the process to that of the first task; None if nothing was computed.
    peak_bytes
        Largest resident memory of any of its processes.
    stages
        CPU seconds by kind of unit and stage, from the commit records.
    approaches
        CPU seconds by approach, of all units that it needs.
    """

    directory: Path
    wall_s: float
    cpu_s: float
    first_task_s: float | None
    peak_bytes: int
    stages: Mapping[str, float] = field(default_factory=dict)
    approaches: Mapping[str, float] = field(default_factory=dict)

    @property
    def computing_s(self) -> float:
        """CPU seconds of all tasks, without starting and publishing."""
        return sum(self.stages.values())


def run(
    text: str, directory: Path, workers: int | None = None, environment: Mapping[str, str] | None = None
) -> RunCost:
    """Run a study given as the text of its file, and return its cost.

    Raises
    ------
    InputError
        If the run fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "study.toml"
        study.write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "railvib", "run", str(study), "--out", str(directory)]
        if workers is not None:
            command += ["--workers", str(workers)]
        output = Path(folder) / "output"
        with output.open("wb") as out:
            start, wall = time.time(), time.perf_counter()
            process = subprocess.Popen(
                command, stdout=out, stderr=out, env={**os.environ, **(environment or {})}
            )
            with _Watch(process.pid) as watch:
                _, status, usage = os.wait4(process.pid, 0)
            wall = time.perf_counter() - wall
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            lines = output.read_text(encoding="utf-8", errors="replace").strip().splitlines()
            raise InputError(f"a run of the benchmark failed: {lines[-1] if lines else process.returncode}")
    run_id = records.Run.load(directory)["run_id"]
    commits = [record for record in records.commits(directory) if record["run_id"] == run_id]
    delays = [datetime.fromisoformat(record["started"]).timestamp() - start for record in commits]
    first = min((delay for delay in delays if delay >= 0.0), default=None)
    return RunCost(
        directory,
        wall,
        max(usage.ru_utime + usage.ru_stime, watch.cpu_s),
        first,
        watch.peak,
        _stages(commits) if first is not None else {},
        _approaches(directory),
    )


def truncate(directory: Path) -> None:
    """Truncate the files of a run to nothing, and leave them in place.

    The next run then meets the same machine as this one did. Deleted files would delay it: ext4 searches past
    each of them for minutes. Files that stay would fill the page cache, so that every run would touch memory
    for the first time, which costs more in a virtual machine.
    """
    for path in directory.rglob("*"):
        if path.is_file():
            os.truncate(path, 0)


def _stages(commits: Iterable[Mapping[str, Any]]) -> dict[str, float]:
    seconds: dict[str, float] = {}
    for record in commits:
        for cost in record["costs"]:
            name = f"{record['kind']}: {cost['stage']}"
            seconds[name] = seconds.get(name, 0.0) + cost["cpu_s"]
    return seconds


def _approaches(directory: Path) -> dict[str, float]:
    """Return the CPU seconds of all units that each approach needs; shared work counts for each in full."""
    seconds = {
        record["unit_id"]: sum(cost["cpu_s"] for cost in record["costs"])
        for record in records.commits(directory)
    }
    needs: dict[str, set[str]] = {}
    for case in records.Run.load(directory)["cases"]:
        for approach, units in case["units"].items():
            needs.setdefault(approach, set()).update(unit["unit_id"] for unit in units)
    return {approach: sum(seconds.get(unit, 0.0) for unit in units) for approach, units in needs.items()}


class _Watch:
    """Samples memory and CPU seconds of a process and its children until the block ends.

    The system adds to a process's seconds those of the children that it waited for, and not all are waited
    for.
    """

    def __init__(self, pid: int) -> None:
        self.peak = 0
        self._cpu_s: dict[tuple[int, float], float] = {}
        self._pid = pid
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._sample, daemon=True)

    def __enter__(self) -> "_Watch":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    @property
    def cpu_s(self) -> float:
        """Seconds of all processes as last seen."""
        return sum(self._cpu_s.values())

    def _sample(self) -> None:
        while not self._stop.wait(_INTERVAL_S):
            try:
                root = psutil.Process(self._pid)
                family = (root, *root.children(recursive=True))
            except psutil.Error:
                continue
            for process in family:
                with contextlib.suppress(psutil.Error):
                    self.peak = max(self.peak, _resident(process))
                    times = process.cpu_times()
                    self._cpu_s[process.pid, process.create_time()] = times.user + times.system


def _resident(process: psutil.Process) -> int:
    """Return the largest resident memory of a process so far, or the present one if that is unknown."""
    try:
        for line in Path(f"/proc/{process.pid}/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return 1024 * int(line.split()[1])
    except OSError:
        pass
    return int(process.memory_info().rss)
