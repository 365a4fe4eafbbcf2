"""Signals by which users, terminals and batch systems end a program: all of them end it as Ctrl-C does."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

INTERRUPTED = 130
"""Exit status of a program that was told to end."""
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
_received: list[int] = []


@contextmanager
def raise_interrupts() -> Iterator[None]:
    """Raise KeyboardInterrupt where a signal asks this process to end; the second Ctrl-C ends it at once.

    A signal that is ignored stays so, as SIGHUP is by nohup.
    """
    _received.clear()
    before = {}
    if threading.current_thread() is threading.main_thread():
        for number in (getattr(signal, name) for name in _NAMES if hasattr(signal, name)):
            if signal.getsignal(number) != signal.SIG_IGN:
                before[number] = signal.signal(number, _interrupt)
    try:
        yield
    finally:
        for number, handler in before.items():
            with suppress(TypeError):  # None: it was not set from Python
                signal.signal(number, handler)


def end_requested() -> bool:
    """Return whether this process has been asked to end.

    Libraries that wait in compiled code turn the KeyboardInterrupt into errors of their own.
    """
    return bool(_received)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _received:
        if number == signal.SIGINT:
            os._exit(INTERRUPTED)
        return
    _received.append(number)
    raise KeyboardInterrupt
