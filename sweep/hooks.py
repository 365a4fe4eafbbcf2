"""What other packages bring to a run, by entry points: they publish its results, and verify those later."""

from contextlib import AbstractContextManager
from importlib import metadata
from pathlib import Path
from typing import Any, Protocol

AFTER_RUN = "railvib.after_run"
"""Group of entry points that return a `Publisher` of a run directory."""
VERIFY = "railvib.verify"
"""Group of entry points that return what is damaged of what was published, or repair it."""


class Publisher(AbstractContextManager[Any], Protocol):
    """Publishes the results of a run; leaving its context ends all that it has started."""

    def get_ready(self) -> None:
        """Begin with what publishing needs, without waiting; called when no task waits any more."""

    def publish(self) -> None:
        """Publish what is there when a run has ended."""


def publishers(directory: Path) -> list[Publisher]:
    """Return who publishes the results of a run directory."""
    return [hook.load()(directory) for hook in metadata.entry_points(group=AFTER_RUN)]


def published_faults(directory: Path, repair: bool = False) -> list[str]:
    """Return what is damaged of what was published, a line each, and make it anew if asked to."""
    hooks = metadata.entry_points(group=VERIFY)
    return [fault for hook in hooks for fault in hook.load()(directory, repair=repair)]
