"""Soils, tracks, trains and tables that many tests share; each is made once per session."""

import gc
import signal
from collections.abc import Callable
from functools import cache

import pytest
from hypothesis import settings

from railvib import library
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import Receiver
from railvib.parameters.track import Track
from railvib.parameters.vehicle import Train, Vehicle
from railvib.transfer.tabulate import transfer_blocks
from railvib.transfer.transfer_function import TransferFunction

# A busy machine makes a right answer slow, not wrong.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

# Who is started in the background ignores Ctrl-C, and so would all that tests start and interrupt.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

Tables = Callable[..., dict[Receiver, TransferFunction]]


def pytest_sessionfinish() -> None:
    """Let go of what commands that ran in this process kept from being looked through for garbage."""
    gc.unfreeze()


@pytest.fixture(scope="session")
def horstwalde() -> Ground:
    return library.load("soil", "horstwalde")


@pytest.fixture(scope="session")
def greby() -> Ground:
    return library.load("soil", "greby")


@pytest.fixture(scope="session")
def track() -> Track:
    return library.load("track", "ballasted-paper")


@pytest.fixture(scope="session")
def vehicle() -> Vehicle:
    return library.load("vehicle", "regina")


@pytest.fixture(scope="session")
def train() -> Train:
    return library.load("train", "grona-taget")


@pytest.fixture(scope="session")
def tables() -> Tables:
    """Return a function that tabulates receivers over a range of blocks, and keeps each block that it
    made.
    """

    @cache
    def block_tables(
        ground: Ground, track: Track, block: int, receivers: tuple[Receiver, ...], tolerance: float
    ):
        return transfer_blocks(ground, track, block, receivers, tolerance)

    def functions(
        ground: Ground, track: Track, blocks: range, receivers: tuple[Receiver, ...], tolerance: float = 1e-4
    ) -> dict[Receiver, TransferFunction]:
        made = [block_tables(ground, track, block, receivers, tolerance) for block in blocks]
        return {
            receiver: TransferFunction((each[receiver] for each in made), track) for receiver in receivers
        }

    return functions
