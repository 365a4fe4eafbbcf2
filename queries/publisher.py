"""The publisher of a run's results; imports little until it prepares."""

from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Self

from queries.refusal import refusing

if TYPE_CHECKING:
    from queries.figures import FigureProcesses


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
        self._processes: FigureProcesses | None = None
        self._begun: Future[Path] | None = None

    def __enter__(self) -> Self:
        """Return itself; leaving the block ends everything that was started."""
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def get_ready(self) -> None:
        """Start to load what publishing needs, while the last tasks run; do not wait."""
        from queries.figures import WORKERS, FigureProcesses

        self._processes = self._stack.enter_context(FigureProcesses(WORKERS))
        thread = self._stack.enter_context(ThreadPoolExecutor(1))
        self._begun = thread.submit(_begin, self._directory)
        self._stack.callback(_remove, self._begun)

    def publish(self) -> None:
        """Bring database, figures and report up to date, and print the comparison."""
        from queries import publication
        from queries.database import is_outdated
        from queries.figures import WORKERS, FigureProcesses

        with refusing(f"; what was computed is kept, `railvib report {self._directory}` publishes it"):
            if self._processes is None:
                # The plotting library is loaded while the database is made.
                workers = WORKERS if is_outdated(self._directory) else 0
                self._processes = self._stack.enter_context(FigureProcesses(workers))
            begun = None if self._begun is None else self._begun.result()
            publication.publish(self._directory, self._processes, begun)


def _begin(directory: Path) -> Path:
    """Import what publishing needs, and create the empty database."""
    from queries import publication  # noqa: F401
    from queries.database import begin

    return begin(directory)


def _remove(begun: "Future[Path]") -> None:
    """Remove an unused empty database, after the run has failed or been interrupted."""
    if begun.exception() is None:
        begun.result().unlink(missing_ok=True)
