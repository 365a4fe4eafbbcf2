"""The engine: a study becomes a plan, the plan tasks, the tasks arrays in Zarr and records beside them."""

from typing import Any

__all__ = ["open_grid"]


def __getattr__(name: str) -> Any:
    """Import `open_grid` when it is first used: xarray takes longer to load than all commands need."""
    if name != "open_grid":
        raise AttributeError(f"module 'sweep' has no attribute {name!r}")
    from sweep.storage.grid import open_grid

    return open_grid
