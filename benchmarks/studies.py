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

_PROGRAM = "from railvib.cli import main; main()"
_LOOK_S = 0.1


@dataclass(frozen=True)
class Ran:
    """What one run took.

    Attributes
    ----------
    directory
        Its output directory.
    wall_s, cpu_s
        From the start of the process to its end; CPU seconds of it and all that it started.
    first_task_s
        From the start of the process to that of the first task; None where nothing was computed.
    peak_bytes
        Largest resident memory of any of its processes.
    stages
        CPU seconds by kind of unit and stage, as the records say.
    approaches
        CPU seconds by approach, of all units that it rests on.
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
) -> Ran:
    """Run a study given as the text of its file, and return what that took.

    Raises
    ------
    InputError
        If the run fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "study.toml"
        study.write_text(text, encoding="utf-8")
        command = [sys.executable, "-c", _PROGRAM, "run", str(study), "--out", str(directory)]
        if workers is not None:
            command += ["--workers", str(workers)]
        output = Path(folder) / "output"
        with output.open("wb") as out:
            started, wall = time.time(), time.perf_counter()
            process = subprocess.Popen(
                command, stdout=out, stderr=out, env={**os.environ, **(environment or {})}
            )
            with _Watch(process.pid) as watch:
                _, status, used = os.wait4(process.pid, 0)
            wall = time.perf_counter() - wall
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            said = output.read_text(encoding="utf-8", errors="replace").strip().splitlines()
            raise InputError(f"a run of the benchmark failed: {said[-1] if said else process.returncode}")
    run_id = records.Run.load(directory)["run_id"]
    made = [record for record in records.committed(directory) if record["run_id"] == run_id]
    begun = [datetime.fromisoformat(record["started"]).timestamp() - started for record in made]
    first = min((each for each in begun if each >= 0.0), default=None)
    return Ran(
        directory,
        wall,
        max(used.ru_utime + used.ru_stime, watch.cpu_s),
        first,
        watch.peak,
        _stages(made) if first is not None else {},
        _approaches(directory),
    )


def empty(directory: Path) -> None:
    """Free what the files of a run take on the disk and in memory, and leave the files.

    The next run finds the machine as this one did. Files that were removed would hold it up when it makes its
    own: ext4 looks past each of them for minutes. And what is written lies in memory first: were none freed,
    every run would take memory that nobody has touched yet, which in a virtual machine costs more.
    """
    for path in directory.rglob("*"):
        if path.is_file():
            os.truncate(path, 0)


def _stages(made: Iterable[Mapping[str, Any]]) -> dict[str, float]:
    spent: dict[str, float] = {}
    for record in made:
        for each in record["costs"]:
            name = f"{record['kind']}: {each['stage']}"
            spent[name] = spent.get(name, 0.0) + each["cpu_s"]
    return spent


def _approaches(directory: Path) -> dict[str, float]:
    """Return what all that each approach rests on has cost, shared work charged to each in full."""
    cost = {
        record["unit_id"]: sum(each["cpu_s"] for each in record["costs"])
        for record in records.committed(directory)
    }
    needed: dict[str, set[str]] = {}
    for case in records.Run.load(directory)["cases"]:
        for approach, units in case["units"].items():
            needed.setdefault(approach, set()).update(unit["unit_id"] for unit in units)
    return {approach: sum(cost.get(unit, 0.0) for unit in units) for approach, units in needed.items()}


class _Watch:
    """Looks at the memory of a process and of all that it started, and at their seconds, until told to stop.

    The system adds to a process's seconds those of the children that it has waited for; some it does not.
    """

    def __init__(self, pid: int) -> None:
        self.peak = 0
        self._cpu_s: dict[tuple[int, float], float] = {}
        self._pid = pid
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)

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

    def _look(self) -> None:
        while not self._stop.wait(_LOOK_S):
            try:
                root = psutil.Process(self._pid)
                family = (root, *root.children(recursive=True))
            except psutil.Error:
                continue
            for process in family:
                with contextlib.suppress(psutil.Error):
                    self.peak = max(self.peak, _resident(process))
                    used = process.cpu_times()
                    self._cpu_s[process.pid, process.create_time()] = used.user + used.system


def _resident(process: psutil.Process) -> int:
    """Return the largest resident memory that a process has had, or where that is not known, has."""
    try:
        for line in Path(f"/proc/{process.pid}/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return 1024 * int(line.split()[1])
    except OSError:
        pass
    return int(process.memory_info().rss)
