"""The transfer functions that several tests read, made once per session."""

import pytest

from tests.railvib.transfer.soft_ground import RECEIVERS, SOFT


@pytest.fixture(scope="session")
def functions(track, tables):
    """Transfer functions by receiver."""
    return tables(SOFT, track, range(-3, 3), RECEIVERS)
