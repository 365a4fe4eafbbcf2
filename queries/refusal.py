"""Refusals: one line on standard error instead of a traceback."""

from collections.abc import Iterator
from contextlib import contextmanager

import click


class Refusal(click.ClickException):
    """A request that cannot be met: one line, exit code 2."""

    exit_code = 2


@contextmanager
def refusing(advice: str = "") -> Iterator[None]:
    """Turn errors of a request, a place or a disk into a refusal.

    Parameters
    ----------
    advice
        Advice at the end of the line.
    """
    from queries.database import ResultsError, reason

    try:
        yield
    except ResultsError as error:
        raise Refusal(f"{error}{advice}") from error
    except BrokenPipeError:  # the reader of our output has closed the pipe
        raise
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        raise Refusal(f"{place}{reason(error)}{advice}") from error
