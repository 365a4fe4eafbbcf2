"""Progress of a run: a bar or plain lines for people, log.jsonl for programs."""

import json
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeRemainingColumn,
)

if TYPE_CHECKING:
    from sweep.plan import Task
    from sweep.running.scheduler import Tally
    from sweep.running.task import Outcome

LOG = "log.jsonl"
PLAIN_INTERVAL_S = 5.0


class Log:
    """Appends what happens to log.jsonl, a JSON object per line, with the run's id in each."""

    def __init__(self, directory: Path, run_id: str) -> None:
        self._file = (directory / LOG).open("a", encoding="utf-8")
        self.run_id = run_id

    def __enter__(self) -> Self:
        """Return the open log."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self._file.close()

    def write(self, event: str, **facts: Any) -> None:
        """Append one line and flush it, so that readers of the file see it at once."""
        line = {
            "time": datetime.now(UTC).isoformat(timespec="milliseconds"),
            "run_id": self.run_id,
            "event": event,
        }
        self._file.write(json.dumps({**line, **facts}, ensure_ascii=False) + "\n")
        self._file.flush()


class Display:
    """Shows progress: a bar on a terminal, otherwise a plain line every few seconds."""

    def __init__(self, total: int) -> None:
        self._console = Console(stderr=True)
        self._started = self._shown = time.monotonic()
        self._total = total
        self._bar: Progress | None = None
        if self._console.is_terminal:
            self._bar = Progress(
                SpinnerColumn(),
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
                TextColumn("{task.fields[facts]}"),
                console=self._console,
            )
            self._line = self._bar.add_task("tasks", total=total, facts="")

    def __enter__(self) -> Self:
        """Start the bar."""
        if self._bar:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the bar, and leave it as it is."""
        if self._bar:
            self._bar.stop()

    def warn(self, text: str) -> None:
        """Show a warning in a line of its own."""
        self._console.print(f"warning: {text}", markup=False, highlight=False, soft_wrap=True)

    def update(self, task: "Task", outcome: "Outcome", tally: "Tally") -> None:
        """Show a task that has settled; failures always get a line."""
        elapsed = time.monotonic() - self._started
        facts = f"{tally.settled / max(elapsed, 1e-3):.1f}/s, {tally.failed} failed, {tally.cpu_s:.0f} CPU-s"
        if outcome.status != "done":
            self._console.print(
                f"{outcome.status}: {task.key}: {outcome.error}",
                markup=False,
                highlight=False,
                soft_wrap=True,
            )
        for text in outcome.warnings:
            self.warn(text)
        if self._bar:
            self._bar.update(self._line, completed=tally.settled, facts=facts)
        elif time.monotonic() - self._shown > PLAIN_INTERVAL_S or tally.settled == self._total:
            self._shown = time.monotonic()
            remaining_s = elapsed / tally.settled * (self._total - tally.settled)
            print(
                f"{tally.settled}/{self._total} tasks, {facts}, {remaining_s:.0f} s left",
                file=sys.stderr,
                flush=True,
            )
