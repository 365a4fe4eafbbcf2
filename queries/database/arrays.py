"""Rows from the arrays of the store: bands and narrow-band lines of spectra, and the rail's receptances."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from queries.database.manifests import Contents, Row
from queries.database.rows import Writer

_BLOCK_DECADES = 0.5
"""Width of a block of frequencies."""

_KEYS = ("contribution", "quantity", "receiver", "averaging")


class Reader:
    """Takes the arrays of one run directory into the tables of a database, unit by unit.

    Parameters
    ----------
    writer
        Of the database.
    directory
        The run directory.
    source
        Its number in the database.
    said
        What its manifests say.
    """

    def __init__(self, writer: Writer, directory: Path, source: int, said: Contents) -> None:
        self._writer = writer
        self._directory = directory
        self._source = source
        self._said = said
        row = writer.connection.execute("SELECT coalesce(max(series_id) + 1, 0) FROM series").fetchone()
        self._series = int(row[0]) if row else 0
        self._cases = {case["case_id"]: case for case in said.tables["cases"]}

    def take(self, record: Row) -> str | None:
        """Insert the rows of one committed unit; return what is wrong with its arrays, if anything."""
        from sweep.storage import store

        try:
            arrays, attributes = store.read_recorded(self._directory, record)
        except store.DamagedError as error:
            return f"the arrays cannot be read: {error}"
        TAKEN[record["kind"]](self, record, arrays, attributes)
        return None

    def _head(self, record: Row) -> dict[str, Any]:
        return {
            "source": self._source,
            **{name: record.get(name) for name in ("run_id", "model_version", "unit_id")},
        }

    def _spectra(
        self, record: Row, arrays: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]
    ) -> None:
        offset = np.asarray(arrays.get("offset_m", attributes.get("offset_m")), dtype=float)
        keys = [
            {"offset_m": None if np.isnan(at) else float(at), **dict(zip(_KEYS, row, strict=True))}
            for at, *row in zip(offset, *(attributes[name] for name in _KEYS), strict=True)
        ]
        band, frequency = arrays["band"], arrays["frequency"]
        shape = (len(keys), band.size)
        share = np.broadcast_to(arrays.get("extrapolated_share", np.nan), shape)
        for case_id, approach in sorted(self._said.owners[record["unit_id"]]):
            head = {"case_id": case_id, "approach": approach, **self._head(record)}
            self._writer.stretches(
                "bands",
                [{**head, **key} for key in keys],
                {
                    "band_hz": np.broadcast_to(band, shape),
                    "mean_square": arrays["mean_square"],
                    "extrapolated_share": share,
                },
            )
            kept = [
                place
                for place, key in enumerate(keys)
                if wanted(self._said.narrow_band, approach, key["receiver"], key["offset_m"])
            ]
            if kept:
                numbers = np.arange(self._series, self._series + len(kept))
                self._series += len(kept)
                self._writer.stretches(
                    "series",
                    [{**head, **keys[place]} for place in kept],
                    {"series_id": numbers[:, None]},
                )
                self._writer.stretches(
                    "psd_lines",
                    [{"series_id": number} for number in numbers.tolist()],
                    {
                        "frequency_hz": np.broadcast_to(frequency, (len(kept), frequency.size)),
                        "value": arrays["psd"] if len(kept) == len(keys) else arrays["psd"][kept],
                    },
                )

    def _receptance(self, record: Row, arrays: Mapping[str, NDArray[Any]], _: Mapping[str, Any]) -> None:
        """Insert the receptance under the load, once for every soil and track whose cases use this unit."""
        names = ("soil", "track", "soil_id", "track_id")
        nearest = int(np.argmin(np.abs(arrays["distance"])))
        own = _own(arrays["frequency"]) if "blocks" in record["inputs"] else slice(None)
        frequency, receptance = arrays["frequency"][own], arrays["receptance"][own, nearest]
        used = {case_id for case_id, _ in self._said.owners[record["unit_id"]]}
        for named in sorted({tuple(self._cases[each][name] for name in names) for each in used}, key=str):
            head = {
                **dict(zip(names, named, strict=True)),
                "speed_kmh": round(float(record["inputs"]["speed"]) * 3.6, 9),
                "distance_m": float(arrays["distance"][nearest]),
                **self._head(record),
            }
            self._writer.stretches(
                "receptances",
                [head],
                {
                    "frequency_hz": frequency[None],
                    "receptance_re": receptance.real[None],
                    "receptance_im": receptance.imag[None],
                },
            )


def _own(frequency: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which frequencies of blocks no other block has.

    Blocks follow one another, each beginning below the end of the one before. A block reaches over half a
    decade in even logarithmic steps, and as far beyond its lower edge as beyond its upper one, which is the
    lower one of the next block.
    """
    position = np.log10(frequency)
    own = np.zeros(frequency.size, bool)
    for rows in np.split(np.arange(frequency.size), np.flatnonzero(np.diff(position) <= 0.0) + 1):
        first, last = position[rows[0]], position[rows[-1]]
        beyond = (last - first - _BLOCK_DECADES) / 2.0
        half_step = (last - first) / (2 * max(rows.size - 1, 1))
        lower = first + max(beyond, 0.0) - half_step
        own[rows] = (position[rows] > lower) & (position[rows] < lower + _BLOCK_DECADES)
    return own


def wanted(setting: Any, approach: str, receiver: str, offset: float | None) -> bool:
    """Return whether a receiver's narrow-band lines belong in the database; what a choice omits matches all.

    Parameters
    ----------
    setting
        "all", "none" or a list of choices with approach, receiver and offset_m.
    approach, receiver, offset
        Of the spectrum; offset in m, None where it has none.
    """
    if isinstance(setting, str):
        return setting == "all"
    return any(
        choice.get("approach") in (None, approach)
        and choice.get("receiver") in (None, receiver)
        and (
            choice.get("offset_m") is None
            or (offset is not None and bool(np.isclose(choice["offset_m"], offset)))
        )
        for choice in setting
    )


_Take = Callable[[Reader, Row, Mapping[str, NDArray[Any]], Mapping[str, Any]], None]
TAKEN: dict[str, _Take] = {"spectra": Reader._spectra, "receptance": Reader._receptance}
"""Kinds of units whose arrays have rows in the database, and what inserts them."""
