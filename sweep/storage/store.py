"""Reading results from the store of a run or a shared store, as dataclasses or plain arrays.

`sweep.storage.group_writer` writes them.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sweep.storage import checksums, fields, location, records
from sweep.storage.fields import Recorded, Result
from sweep.storage.group import MEMBERS, Group
from sweep.storage.group import DamagedError as DamagedError

if TYPE_CHECKING:
    import zarr

STORE = "transfer_functions.zarr"
GROUP_FIELDS = ("group", "member", "arrays", "metadata", "group_metadata")
"""Entries of a record that describe its group."""


def read(
    home: records.Home,
    group: str,
    result_type: type[Result],
    arrays: Recorded | None = None,
    metadata: str | None = None,
    group_metadata: str | None = None,
    member: str | None = None,
) -> Result:
    """Read a group of the store at `home` as a `result_type`, and check it against its record.

    An array is checked by its sha256 or, if this process has written or checked it before, by the checksums
    of its chunks; an array in memory is not read again. If the record has the sha256 of the group's own
    metadata, no others are read, as these repeat those of the arrays.

    Raises
    ------
    DamagedError
        If the group is missing, cannot be decoded or is not the recorded one.
    """
    values, attributes = _read(home, group, arrays, metadata, group_metadata, member)
    return fields.restore(result_type, values, attributes, arrays)


def read_result(
    directory: Path | str, record: Mapping[str, Any]
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return the arrays of a record by name, checked as in `read`, and the group's attributes.

    Raises
    ------
    DamagedError
        If the group is missing, cannot be decoded or is not the recorded one.
    """
    recorded: dict[str, Any] = {name: record.get(name) for name in GROUP_FIELDS}
    return _read(_home(directory, record["group"]), **recorded)


def _read(
    home: records.Home,
    group: str,
    arrays: Recorded | None,
    metadata: str | None,
    group_metadata: str | None,
    member: str | None,
) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    place, prefix = location.at(home), f"{STORE}/{group}"
    known = checksums.arrays_in_memory(arrays or {})
    if group_metadata is None:
        stored = Group.read_whole(place, prefix, group, metadata, member)
    else:
        stored = Group.read_unknown(place, prefix, group, group_metadata, known, member)
    return stored.arrays() if arrays is None else stored.verify(arrays, known), stored.attributes


def check(directory: Path | str, record: Mapping[str, Any]) -> None:
    """Read the group of a record, and check all of it against the recorded sha256.

    Raises
    ------
    DamagedError
        If the group is missing, cannot be decoded or is not the recorded one.
    """
    name = record["group"]
    place = location.at(_home(directory, name))
    group = Group.read_whole(place, f"{STORE}/{name}", name, record.get("metadata"), record.get("member"))
    group.check(record["arrays"])


def open_array(directory: Path | str, group: str, name: str) -> "zarr.Array[Any]":
    """Open one array of a group of a run, to read parts of it."""
    import zarr

    place = location.at(_home(directory, group))
    return zarr.open_array(place.zarr(f"{STORE}/{group}/{name}"), mode="r")


def read_array(directory: Path | str, group: str, member: str | None, name: str) -> NDArray[Any]:
    """Return one array of a result, unchecked."""
    array = open_array(directory, group, name)
    members = array.attrs.get(MEMBERS)
    if member is None or members is None:
        return np.asarray(array[...])
    assert isinstance(members, dict)
    return np.asarray(array[list(members).index(member)])


def _home(directory: Path | str, group: str) -> records.Home:
    """Return where a group of a run is stored: with the run if it is there, else in the shared store."""
    run, *outside = records.homes(directory)
    return run if not outside or (Path(run) / STORE / group).is_dir() else outside[0]


def clean(home: records.Home, older_than_s: float = 0.0) -> None:
    """Remove unfinished groups of dead writers; while others may be writing, only old ones."""
    location.at(home).clean(STORE, older_than_s)
