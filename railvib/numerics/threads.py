"""Linear algebra on one thread: to share out matrices as small as these costs far more than it saves."""

from collections.abc import Iterator
from contextlib import contextmanager

import scipy.linalg  # noqa: F401  brings the library that is to be limited
from threadpoolctl import ThreadpoolController

_CONTROLLER = ThreadpoolController()


@contextmanager
def single() -> Iterator[None]:
    """Keep linear algebra to one thread, inside a block or a function that this decorates."""
    with _CONTROLLER.limit(limits=1, user_api="blas"):
        yield
