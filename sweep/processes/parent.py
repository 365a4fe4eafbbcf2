"""Processes that the system kills when their parent ends, however it ends. On Linux only."""

import ctypes
import os
import signal
import sys

_SET_PARENT_DEATH_SIGNAL = 1
_forking = 0


def end_with(parent: int) -> None:
    """Let this process be killed when the thread that started it ends; end now if `parent` has ended."""
    _set_death_signal(signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def outlive() -> None:
    """Let this process survive its parent's end, which it notices by other means."""
    _set_death_signal(0)


def let_forks_end_with_this_process() -> None:
    """Let processes forked from this one end with it, and theirs with them."""
    os.register_at_fork(before=_remember_this_process, after_in_child=lambda: end_with(_forking))


def _remember_this_process() -> None:
    global _forking
    _forking = os.getpid()


def _set_death_signal(number: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, number)
