"""Whether there is anybody left to compute: said while a run waits, and the end of it when none comes."""

import sys
import time

PATIENCE_MIN = 60.0
"""How long a run waits for workers when all are gone, unless it is told otherwise."""
SAY_S = 30.0, 600.0
"""When a run that waits says so first, and how often after that."""


class WorkersLostError(Exception):
    """Nobody computes any more; what is done is kept."""


class Watch:
    """Follows how many workers there are.

    Parameters
    ----------
    awaited
        Description of the missing workers, such as ``workers at tcp://head:8786``.
    patience_min
        Minutes without workers after which the run ends; None waits for ever.
    """

    def __init__(self, awaited: str, patience_min: float | None) -> None:
        self._awaited = awaited
        self._patience_s = None if patience_min is None else 60.0 * patience_min
        self._alone_since: float | None = None
        self._say_after_s = SAY_S[0]

    def see(self, workers: int) -> None:
        """Take note of how many workers there are now.

        Raises
        ------
        WorkersLostError
            If there have been none for too long.
        """
        if workers:
            self._alone_since, self._say_after_s = None, SAY_S[0]
            return
        now = time.monotonic()
        if self._alone_since is None:
            self._alone_since = now
        waited_s = now - self._alone_since
        if self._patience_s is not None and waited_s >= self._patience_s:
            raise WorkersLostError(f"{self._awaited}: none for {_minutes(waited_s)}, the limit set by --wait")
        if waited_s >= self._say_after_s:
            limit = "" if self._patience_s is None else f"; the run ends after {_minutes(self._patience_s)}"
            print(f"waiting for {self._awaited}, for {_minutes(waited_s)} so far{limit}", file=sys.stderr)
            sys.stderr.flush()
            self._say_after_s = waited_s + SAY_S[1]


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"
