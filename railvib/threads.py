"""Linear algebra on one thread: to share out matrices as small as these costs far more than it saves."""

from contextlib import AbstractContextManager
from typing import Any

import scipy.linalg  # noqa: F401  brings the library that is to be limited
from threadpoolctl import ThreadpoolController

_CONTROLLER = ThreadpoolController()


def single() -> AbstractContextManager[Any]:
    """Return a context in which linear algebra keeps to one thread."""
    limited: AbstractContextManager[Any] = _CONTROLLER.limit(limits=1, user_api="blas")
    return limited
