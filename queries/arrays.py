"""Rows from the arrays of the store: bands and narrow-band lines of spectra, and the rail's receptances."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from queries.manifests import Contents, Row
from queries.rows import Writer

_BLOCK_DECADES = 0.5
"""Width of a block of frequencies."""

_KEYS = ("contribution", "quantity", "receiver", "averaging")


def insert(writer: Writer, directory: Path, record: Row, said: Contents) -> str | None:
    """Insert the rows of one committed unit; return what is wrong with its arrays, if they cannot be read."""
    from sweep import store

    try:
        arrays, attributes = store.read_arrays(directory, record["group"])
    except store.DamagedError as error:
        return f"the arrays cannot be read: {error}"
    # A chunk that is missing reads as NaN without complaint: only the checksums tell.
    for name, expected in record["arrays"].items():
        if name not in arrays or store.checksum(arrays[name]) != expected:
            return f"the array {name} is not the one recorded"
    KINDS[record["kind"]](writer, record, said, arrays, attributes)
    return None


def _insert_spectra(
    writer: Writer,
    record: Row,
    said: Contents,
    arrays: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
) -> None:
    offset = np.asarray(arrays.get("offset_m", attributes.get("offset_m")), dtype=float)
    keys = [
        {"offset_m": float(at), **dict(zip(_KEYS, row, strict=True))}
        for at, *row in zip(offset, *(attributes[name] for name in _KEYS), strict=True)
    ]
    band, frequency = arrays["band"], arrays["frequency"]
    share = arrays.get("extrapolated_share", np.full(band.size, np.nan))
    source = {name: record.get(name) for name in ("run_id", "model_version", "unit_id")}
    for case_id, approach in sorted(said.owners[record["unit_id"]]):
        head = {"case_id": case_id, "approach": approach, **source}
        rows = len(keys) * band.size
        writer.columns(
            "bands",
            {
                **{name: [value] * rows for name, value in head.items()},
                **{name: [key[name] for key in keys for _ in band] for name in ("offset_m", *_KEYS)},
                "band_hz": np.tile(band, len(keys)),
                "mean_square": arrays["mean_square"].ravel(),
                "extrapolated_share": np.tile(share, len(keys)),
            },
        )
        ((first,),) = writer.connection.execute(
            "SELECT coalesce(max(series_id) + 1, 0) FROM series"
        ).fetchall()
        kept = [
            place
            for place, key in enumerate(keys)
            if wanted(said.narrow_band, approach, key["receiver"], key["offset_m"])
        ]
        series = np.arange(first, first + len(kept), dtype=np.int32)
        writer.rows(
            "series",
            [{**head, **keys[place], "series_id": int(id_)} for id_, place in zip(series, kept, strict=True)],
        )
        lines = {
            "series_id": np.repeat(series, frequency.size),
            "frequency_hz": np.tile(frequency, len(kept)),
            "value": np.ascontiguousarray(arrays["psd"][kept], dtype=float).ravel(),
        }
        writer.plain("psd_lines", lines)


def _insert_receptance(
    writer: Writer,
    record: Row,
    said: Contents,
    arrays: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
) -> None:
    """Insert the receptance under the load, once for every soil and track whose cases use this unit."""
    cases = {row["case_id"]: row for row in said.tables["cases"]}
    used = {case_id for case_id, _ in said.owners[record["unit_id"]]}
    names = ("soil", "track", "soil_id", "track_id")
    nearest = int(np.argmin(np.abs(arrays["distance"])))
    own = _own(arrays["frequency"]) if "block" in record["inputs"] else slice(None)
    frequency, receptance = arrays["frequency"][own], arrays["receptance"][own, nearest]
    for named in sorted({tuple(cases[case_id][name] for name in names) for case_id in used}, key=str):
        single = {
            **dict(zip(names, named, strict=True)),
            "speed_kmh": round(float(record["inputs"]["speed"]) * 3.6, 9),
            "distance_m": float(arrays["distance"][nearest]),
            **{name: record.get(name) for name in ("run_id", "model_version", "unit_id")},
        }
        writer.columns(
            "receptances",
            {
                **{name: [value] * frequency.size for name, value in single.items()},
                "frequency_hz": frequency,
                "receptance_re": receptance.real,
                "receptance_im": receptance.imag,
            },
        )


def _own(frequency: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which frequencies of a block no other block has.

    A block reaches over half a decade in even logarithmic steps, and as far beyond its lower edge as beyond
    its upper one, which is the lower one of the next block.
    """
    position = np.log10(frequency)
    beyond = (position[-1] - position[0] - _BLOCK_DECADES) / 2.0
    half_step = (position[-1] - position[0]) / (2 * max(frequency.size - 1, 1))
    lower = position[0] + max(beyond, 0.0) - half_step
    return np.asarray((position > lower) & (position < lower + _BLOCK_DECADES))


def wanted(setting: Any, approach: str, receiver: str, offset: float) -> bool:
    """Return whether a receiver's narrow-band lines belong in the database; what a choice omits matches all.

    Parameters
    ----------
    setting
        "all", "none" or a list of choices with approach, receiver and offset_m.
    approach, receiver, offset
        Of the spectrum; offset in m, NaN where it has none.
    """
    if isinstance(setting, str):
        return setting == "all"
    return any(
        choice.get("approach") in (None, approach)
        and choice.get("receiver") in (None, receiver)
        and (choice.get("offset_m") is None or bool(np.isclose(choice["offset_m"], offset)))
        for choice in setting
    )


_Insert = Callable[[Writer, Row, Contents, Mapping[str, NDArray[Any]], Mapping[str, Any]], None]
KINDS: dict[str, _Insert] = {"spectra": _insert_spectra, "receptance": _insert_receptance}
"""Kinds of units whose arrays have rows in the database, and what inserts them."""
