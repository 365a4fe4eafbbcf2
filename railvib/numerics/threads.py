"""Linear algebra on one thread: to share out matrices as small as these costs far more than it saves."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import scipy.linalg  # noqa: F401  brings the library that is to be limited
from threadpoolctl import ThreadpoolController

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

_CONTROLLER = ThreadpoolController()


def single() -> AbstractContextManager[Any]:
    """Return a context in which linear algebra keeps to one thread."""
    limited: AbstractContextManager[Any] = _CONTROLLER.limit(limits=1, user_api="blas")
    return limited


def limited(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Let a function's linear algebra keep to one thread."""

    @wraps(function)
    def call(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        with single():
            return function(*args, **kwargs)

    return call
