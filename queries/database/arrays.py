"""Rows from the arrays of the store: spectra, levels of passages, and the rail's receptances."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from queries.database.manifests import Contents, Row
from queries.database.rows import Writer

_KEYS = ("contribution", "quantity", "receiver", "averaging")
_NAMES = ("soil", "track", "soil_id", "track_id")
_KMH = 3.6


class Reader:
    """Inserts the arrays of one run directory into the tables of a database, unit by unit.

    Parameters
    ----------
    writer
        Of the database.
    directory
        The run directory.
    source
        Its number in the database.
    contents
        The content of its manifests.
    """

    def __init__(self, writer: Writer, directory: Path, source: int, contents: Contents) -> None:
        self._writer = writer
        self._directory = directory
        self._source = source
        self._contents = contents
        row = writer.connection.execute("SELECT coalesce(max(series_id) + 1, 0) FROM series").fetchone()
        self._next_series = int(row[0]) if row else 0

    def read(self, record: Row) -> str | None:
        """Insert the rows of one committed unit; return the fault of its arrays, if any."""
        from sweep.storage import store

        try:
            arrays, attributes = store.read_result(self._directory, record)
        except store.DamagedError as error:
            return f"the arrays cannot be read: {error}"
        INSERTS[record["kind"]](self, record, arrays, attributes)
        return None

    def _origin(self, record: Row) -> dict[str, Any]:
        """Return the columns that say where rows come from."""
        names = ("run_id", "model_version", "unit_id")
        return {"source": self._source, **{name: record.get(name) for name in names}}

    def _insert_spectra(
        self, record: Row, arrays: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]
    ) -> None:
        offsets = np.asarray(arrays.get("offset_m", attributes.get("offset_m")), dtype=float)
        keys = [
            {"offset_m": None if np.isnan(offset) else float(offset), **dict(zip(_KEYS, row, strict=True))}
            for offset, *row in zip(offsets, *(attributes[name] for name in _KEYS), strict=True)
        ]
        band, mean_square = arrays["band"], arrays["mean_square"]
        shape = mean_square.shape
        numbers = {
            "band_hz": np.broadcast_to(band, shape),
            "mean_square": mean_square,
            "peak_mean_square": np.broadcast_to(_peaks(keys, mean_square)[:, None], shape),
            "extrapolated_share": np.broadcast_to(arrays.get("extrapolated_share", np.nan), shape),
        }
        for case_id, approach in sorted(self._contents.owners[record["unit_id"]]):
            head = {"case_id": case_id, "approach": approach, **self._origin(record)}
            self._writer.stretches("bands", [{**head, **key} for key in keys], numbers)
            chosen = [
                place
                for place, key in enumerate(keys)
                if wanted(self._contents.narrow_band, approach, key["receiver"], key["offset_m"])
            ]
            if chosen:
                heads = [{**head, **keys[place]} for place in chosen]
                psd = arrays["psd"] if len(chosen) == len(keys) else arrays["psd"][chosen]
                self._insert_lines(heads, arrays["frequency"], psd)

    def _insert_lines(self, heads: list[dict[str, Any]], frequency: NDArray[Any], psd: NDArray[Any]) -> None:
        """Insert narrow-band spectra: a series each, and its lines."""
        numbers = np.arange(self._next_series, self._next_series + len(heads))
        self._next_series += len(heads)
        self._writer.stretches("series", heads, {"series_id": numbers[:, None]})
        self._writer.stretches(
            "psd_lines",
            [{"series_id": number} for number in numbers.tolist()],
            {"frequency_hz": np.broadcast_to(frequency, psd.shape), "value": psd},
        )

    def _insert_passage_levels(
        self, record: Row, arrays: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]
    ) -> None:
        """Insert the statistics of metrics of passages; all of them are of the vertical component."""
        offsets = np.asarray(arrays.get("offset_m", attributes.get("offset_m")), dtype=float)
        names = ("receiver", "metric", "statistic", "unit")
        rows = [
            {**dict(zip(names, row, strict=True)), "offset_m": None if np.isnan(offset) else float(offset)}
            for offset, *row in zip(offsets, *(attributes[name] for name in names), strict=True)
        ]
        value = np.asarray(arrays["value"], dtype=float)[:, None]
        for case_id, approach in sorted(self._contents.owners[record["unit_id"]]):
            head = {"case_id": case_id, "approach": approach, "component": "z", **self._origin(record)}
            self._writer.stretches("passage_levels", [{**head, **row} for row in rows], {"value": value})

    def _insert_receptance(
        self, record: Row, arrays: Mapping[str, NDArray[Any]], _: Mapping[str, Any]
    ) -> None:
        """Insert the receptance under the load, once for every soil and track whose cases use this unit."""
        nearest = int(np.argmin(np.abs(arrays["distance"])))
        # Older stores lack `inside`; their extra frequencies agree with those of neighbouring blocks.
        inside = arrays.get("inside", np.ones(arrays["frequency"].size, bool))
        frequency, first = np.unique(arrays["frequency"][inside], return_index=True)
        receptance = arrays["receptance"][inside, nearest][first]
        for names in self._contents.label_values(record["unit_id"], _NAMES):
            head = {
                **dict(zip(_NAMES, names, strict=True)),
                "speed_kmh": round(float(record["inputs"]["speed"]) * _KMH, 9),
                "distance_m": float(arrays["distance"][nearest]),
                **self._origin(record),
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


def _peaks(keys: list[dict[str, Any]], mean_square: NDArray[Any]) -> NDArray[np.float64]:
    """Return per series the largest band of any contribution to the same quantity at the same receiver."""
    peaks: dict[tuple[Any, ...], float] = {}
    names = ("quantity", "receiver", "offset_m", "averaging")
    places = [tuple(key[name] for name in names) for key in keys]
    for place, largest in zip(places, mean_square.max(axis=1).tolist(), strict=True):
        peaks[place] = max(largest, peaks.get(place, 0.0))
    return np.array([peaks[place] for place in places])


def wanted(setting: Any, approach: str, receiver: str, offset: float | None) -> bool:
    """Return whether a receiver's lines belong in the database; keys that a choice omits match all.

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


_Insert = Callable[[Reader, Row, Mapping[str, NDArray[Any]], Mapping[str, Any]], None]
INSERTS: dict[str, _Insert] = {
    "spectra": Reader._insert_spectra,
    "passage_levels": Reader._insert_passage_levels,
    "receptance": Reader._insert_receptance,
}
"""Methods that insert the arrays of a stage; records and rows call the stage `kind`."""
