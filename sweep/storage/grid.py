"""All transfer functions of a run as one lazy dataset, assembled from the groups of the store."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import dask.array
import numpy as np
import xarray
from dask.delayed import delayed
from numpy.typing import NDArray

from railvib.numerics import frequency_blocks as blocks
from railvib.parameters.receiver import Receiver
from railvib.parameters.units import KMH
from sweep.storage import records, store

Column = tuple[str, str, Any]
"""Soil, track, and a `Receiver` or a speed in km/h: where a part lies along the axes of the grid."""


def open_grid(directory: Path | str) -> xarray.Dataset:
    """Return the transfer functions that the latest run of a directory needs; arrays are read when used.

    Parameters
    ----------
    directory
        The run's output directory.

    Returns
    -------
    xarray.Dataset
        ``transfer(soil, track, receiver, frequency, node)`` of the rail and the ground, with ``offset_m``
        along receiver, and ``rail_moving(soil, track, speed_kmh, frequency, moving_node)`` where a full model
        was asked for. Their wavenumbers are coordinates, ``wavenumber`` and ``moving_wavenumber``, over all
        of their dimensions. A chunk is one block of one stored group; where it has no value there is NaN.

    Raises
    ------
    FileNotFoundError
        If the directory holds no run.
    """
    manifest = records.Run.load(directory)
    names: dict[str, set[tuple[str, str]]] = {}
    for case in manifest["cases"]:
        for units in case["units"].values():
            for unit in units:
                names.setdefault(unit["unit_id"], set()).add((case["soil"], case["track"]))
    fixed: list[_Part] = []
    moving: list[_Part] = []
    for stage, parts in (("transfer", fixed), ("moving_transfer", moving)):
        for record in records.commits(directory, stage):
            for soil, track in sorted(names.get(record["unit_id"], ())):
                parts += _parts(directory, record, soil, track)
    frequency = {
        block: np.unique(
            np.concatenate([part.frequency for part in (*fixed, *moving) if part.block == block])
        )
        for block in sorted({part.block for part in (*fixed, *moving)})
    }
    receivers: list[Receiver] = sorted({part.column[2] for part in fixed}, key=lambda receiver: receiver.rank)
    speeds = sorted({part.column[2] for part in moving})
    soils, tracks = ([*dict.fromkeys(case[name] for case in manifest["cases"])] for name in ("soil", "track"))
    along = {"soil": soils, "track": tracks}
    grid = xarray.Dataset(
        {
            **_variables(
                fixed, frequency, {**along, "receiver": receivers}, "node", "transfer", "wavenumber"
            ),
            **_variables(
                moving,
                frequency,
                {**along, "speed_kmh": speeds},
                "moving_node",
                "rail_moving",
                "moving_wavenumber",
            ),
        },
        coords={
            **along,
            **_receiver_coordinates(receivers),
            "speed_kmh": ("speed_kmh", speeds, {"units": "km/h"}),
            "frequency": ("frequency", np.concatenate([*frequency.values(), []]), {"units": "Hz"}),
        },
        attrs={"study": manifest["study_name"], "run_id": manifest["run_id"]},
    )
    return grid.set_coords([name for name in ("wavenumber", "moving_wavenumber") if name in grid])


def _receiver_coordinates(receivers: Sequence[Receiver]) -> dict[str, Any]:
    """Return the names and offsets of receivers as the grid has them, NaN on the rail."""
    return {
        "receiver": [str(receiver.key) for receiver in receivers],
        "offset_m": ("receiver", [receiver.offset_m for receiver in receivers], {"units": "m"}),
    }


@dataclass(frozen=True)
class _Part:
    """A block of a stored group: its place in the grid, and its frequencies inside the block's edges."""

    directory: Path | str
    group: str
    member: str | None
    """Which result of the group it is."""
    values: str
    """Name of the array of values; the other one is called wavenumber."""
    column: Column
    block: int
    inside: NDArray[np.bool_]
    frequency: NDArray[np.float64]
    nodes: int


def _parts(directory: Path | str, record: Mapping[str, Any], soil: str, track: str) -> Iterator[_Part]:
    """Yield the blocks of a stored group."""
    group, member, inputs = record["group"], record.get("member"), record["inputs"]
    values = next(name for name in ("rail", "ground", "rail_moving") if name in record["arrays"])
    frequency = store.read_array(directory, group, member, "frequency")
    third = Receiver.of(inputs["receiver"]) if "receiver" in inputs else round(inputs["speed"] * KMH, 9)
    for block in inputs["blocks"] if "blocks" in inputs else [inputs["block"]]:
        low, high = blocks.edges(int(block))
        inside = (frequency >= low * (1.0 - 1e-9)) & (frequency < high * (1.0 - 1e-9))
        yield _Part(
            directory,
            group,
            member,
            values,
            (soil, track, third),
            int(block),
            inside,
            frequency[inside],
            record["arrays"][values]["shape"][1],
        )


def _variables(
    parts: Sequence[_Part],
    frequency: Mapping[int, NDArray[np.float64]],
    axes: Mapping[str, Sequence[Any]],
    node: str,
    value: str,
    wavenumber: str,
) -> dict[str, tuple[tuple[str, ...], dask.array.Array, dict[str, str]]]:
    """Return the values and the wavenumbers of some parts on the common grid, as variables of a dataset."""
    if not parts:
        return {}
    part_at = {(part.column, part.block): part for part in parts}
    nodes = max((part.nodes for part in parts), default=0)
    dims = (*axes, "frequency", node)

    def assemble(dtype: type) -> dask.array.Array:
        def assemble_column(column: Column) -> dask.array.Array:
            pieces = [
                _piece(part_at.get((column, block)), rows, nodes, dtype) for block, rows in frequency.items()
            ]
            joined: dask.array.Array = dask.array.concatenate(pieces, axis=0)
            return joined

        soils, tracks, thirds = axes.values()
        columns = [assemble_column(column) for column in product(soils, tracks, thirds)]
        stacked: dask.array.Array = dask.array.stack(columns)
        grid: dask.array.Array = stacked.reshape((len(soils), len(tracks), len(thirds), *stacked.shape[1:]))
        return grid

    return {
        value: (dims, assemble(complex), {"units": "m2/N"}),
        wavenumber: (dims, assemble(float), {"units": "rad/m"}),
    }


def _piece(part: _Part | None, frequency: NDArray[np.float64], nodes: int, dtype: type) -> dask.array.Array:
    """Return one block's values, or as floats its wavenumbers, read when used; NaN where there is none."""
    shape = (frequency.size, nodes)
    nothing = complex(np.nan, np.nan) if dtype is complex else np.nan
    if part is None:
        empty: dask.array.Array = dask.array.full(shape, nothing, dtype=dtype, chunks=shape)
        return empty
    rows = np.searchsorted(frequency, part.frequency)
    array = part.values if dtype is complex else "wavenumber"
    stored = part.directory, part.group, part.member, array
    later = delayed(_read, pure=True)(stored, part.inside, rows, shape, nothing)
    block: dask.array.Array = dask.array.from_delayed(later, shape=shape, dtype=dtype)
    return block


def _read(
    array: tuple[Path | str, str, str | None, str],
    inside: NDArray[np.bool_],
    rows: NDArray[np.intp],
    shape: tuple[int, int],
    nothing: complex,
) -> NDArray[Any]:
    stored = store.read_array(*array)
    out = np.full(shape, nothing, dtype=stored.dtype)
    out[rows, : stored.shape[1]] = stored[inside]
    return out
