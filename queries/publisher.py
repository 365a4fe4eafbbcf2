"""Whoever publishes the results of a run that the engine computes; light until it gets ready."""

import importlib
from contextlib import ExitStack
from pathlib import Path
from threading import Thread
from typing import Self

from queries.crew import WORKERS, Crew


class Publisher:
    """Publishes the results of a run directory, see `queries.publication`.

    Parameters
    ----------
    directory
        Of the run.
    """

    def __init__(self, directory: Path | str) -> None:
        self._directory = Path(directory)
        self._stack = ExitStack()
        self._crew: Crew | None = None

    def __enter__(self) -> Self:
        """Return itself; leaving the block ends all that has been started."""
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def get_ready(self) -> None:
        """Begin to load all that publishing takes, while the last tasks run; does not wait."""
        self._crew = self._stack.enter_context(Crew(WORKERS))
        Thread(target=importlib.import_module, args=["queries.publication"]).start()

    def publish(self) -> None:
        """Bring database, figures and report up to date, and print the comparison."""
        from queries import ingest, publication

        if self._crew is None:
            # Whoever draws loads the plotting library while the database is made.
            workers = WORKERS if ingest.is_outdated(self._directory) else 0
            self._crew = self._stack.enter_context(Crew(workers))
        publication.publish(self._directory, self._crew)
