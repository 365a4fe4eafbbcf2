"""Hooks of other packages, found by entry points: they publish results of a run, and verify them later."""

from contextlib import AbstractContextManager
from importlib import metadata
from pathlib import Path
from typing import Any, Protocol

AFTER_RUN = "railvib.after_run"
"""Group of entry points that return a `Publisher` of a run directory."""
VERIFY = "railvib.verify"
"""Group of entry points that report damage of published files, or repair it."""


class Publisher(AbstractContextManager[Any], Protocol):
    """Publishes the results of a run; leaving its context ends all that it has started."""

    def get_ready(self) -> None:
        """Start preparations without waiting; called when no task is left to hand out."""

    def publish(self) -> None:
        """Publish the results after a run has ended."""


def publishers(directory: Path) -> list[Publisher]:
    """Return the publishers of a run directory."""
    return [hook.load()(directory) for hook in metadata.entry_points(group=AFTER_RUN)]


def published_faults(directory: Path, repair: bool = False) -> list[str]:
    """Return one line for each damaged published file, and repair these if asked to."""
    hooks = metadata.entry_points(group=VERIFY)
    return [fault for hook in hooks for fault in hook.load()(directory, repair=repair)]
