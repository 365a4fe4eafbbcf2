"""Data of the report: levels, spectra, receptances and costs as compact arrays."""

import math
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries import answers
from queries.figures.lines import approach_line
from queries.report import spectra
from queries.report.packing import NONE, hundredths, text
from queries.report.spectra import CONTRIBUTIONS, Sizes
from queries.statements import statements

_SQL = statements("queries.report", "data")
_SYMBOLS = {"o": "circle", "s": "square", "D": "diamond", "^": "triangle-up", "v": "triangle-down", "x": "x"}
_AXES = ("soil", "track", "train", "unevenness", "speed_kmh")

Data = dict[str, Any]


def data(connection: duckdb.DuckDBPyConnection) -> Data:
    """Return all data of the page, ready for JSON."""
    approaches = answers.requested_approaches(connection)
    sizes = _number(connection, approaches)
    axes, cases = _cases(connection)
    rows = connection.execute("SELECT band_hz FROM page_bands ORDER BY number").fetchall()
    bands = [band_hz for (band_hz,) in rows]
    return {
        "reference": answers.reference(connection),
        "approaches": [_style(name) for name in approaches],
        "axes": axes,
        "cases": cases,
        "contributions": CONTRIBUTIONS,
        "receivers": _receivers(connection),
        "bands": bands,
        "band_names": [answers.band(value) for value in bands],
        "levels": _levels(connection, sizes),
        "extrapolated": _extrapolated_bands(connection, sizes),
        "receptances": _receptances(connection),
        "unevenness": _unevenness(connection),
        "costs": _costs(connection),
        "trains": _trains(connection),
        "lines": spectra.spectra(connection, sizes),  # last, as it fills DuckDB's memory
    }


def _number(connection: duckdb.DuckDBPyConnection, approaches: list[str]) -> Sizes:
    """Give cases, approaches, receivers and bands their numbers on the page, in tables of this connection."""
    tables = {"approaches": [approaches], "contributions": [list(CONTRIBUTIONS)]}
    for name in ("cases", "receivers", "bands", *tables):
        query = _SQL[f"page-{name}"]
        connection.execute(f"CREATE OR REPLACE TEMP TABLE page_{name} AS {query}", tables.get(name, []))
    counts = [
        connection.execute(f"SELECT count(*) FROM page_{name}").fetchone() or (0,)
        for name in ("cases", "approaches", "receivers", "bands")
    ]
    return Sizes(*(int(row[0]) for row in counts))


def _style(approach: str) -> Data:
    line = approach_line(approach)
    return {
        "name": approach,
        "label": line.label.strip(),
        "colour": line.colour,
        "dash": ",".join(f"{2 * length:g}px" for length in line.dashes) or "solid",
        "symbol": _SYMBOLS.get(line.marker, "circle"),
        "width": round(1.4 * line.width, 2),
        "size": round(1.6 * line.marker_size, 1),
    }


def _cases(connection: duckdb.DuckDBPyConnection) -> tuple[Data, list[list[int]]]:
    """Return the values of each axis in study order, and each case's positions on them."""
    rows = connection.execute(f"SELECT {', '.join(_AXES)} FROM page_cases ORDER BY number").fetchall()
    columns = list(zip(*rows, strict=True)) or [()] * len(_AXES)
    axes = {name: list(dict.fromkeys(column)) for name, column in zip(_AXES, columns, strict=True)}
    axes["speed_kmh"].sort()
    places = {name: {value: place for place, value in enumerate(values)} for name, values in axes.items()}
    return axes, [[places[name][value] for name, value in zip(_AXES, row, strict=True)] for row in rows]


def _receivers(connection: duckdb.DuckDBPyConnection) -> list[Data]:
    query = "SELECT quantity, receiver, offset_m FROM page_receivers ORDER BY number"
    return [
        {"quantity": quantity, "receiver": receiver, "offset_m": offset, "label": _place(receiver, offset)}
        for quantity, receiver, offset in connection.execute(query).fetchall()
    ]


def _place(receiver: str, offset: float | None) -> str:
    if receiver == "ground":
        return f"ground at {offset:g} m"
    return receiver.replace("axle-", "axle ") + (" (leading)" if receiver == "axle-1" else "")


def _levels(connection: duckdb.DuckDBPyConnection, sizes: Sizes) -> str:
    """Return levels over (case, approach, contribution, receiver, band)."""
    shape = (sizes.cases, sizes.approaches, len(CONTRIBUTIONS), sizes.receivers, sizes.bands)
    columns = connection.execute(_SQL["levels"], list(shape[1:])).fetchnumpy()
    packed = np.full(math.prod(shape), NONE, dtype="<i2")
    packed[np.asarray(columns["place"])] = hundredths(columns["level_db"])
    return text(packed)


def _extrapolated_bands(connection: duckdb.DuckDBPyConnection, sizes: Sizes) -> list[list[int]]:
    """Return per case the bands in which most unevenness is extrapolated."""
    bands: list[list[int]] = [[] for _ in range(sizes.cases)]
    for case, numbers in connection.execute(_SQL["extrapolated"]).fetchall():
        bands[case] = numbers
    return bands


def _receptances(connection: duckdb.DuckDBPyConnection) -> list[Data]:
    """Return magnitude [1e-9 m/N] and phase [rad] of the rail's receptance per soil, track and speed."""
    curves = []
    for soil, track, speed, frequency, *parts in connection.execute(_SQL["receptances"]).fetchall():
        value = np.array(parts[0]) + 1j * np.array(parts[1])
        curves.append(
            {
                "soil": soil,
                "track": track,
                "speed_kmh": speed,
                "frequency": _round(np.array(frequency)),
                "magnitude": _round(1e9 * np.abs(value)),
                "phase": _round(np.unwrap(np.angle(value))),
            }
        )
    return curves


def _unevenness(connection: duckdb.DuckDBPyConnection) -> list[Data]:
    return [
        {
            "name": name,
            "wavelength": _round(np.array(wavelength)),
            "level": [None if value is None else round(value, 2) for value in level],
            "extrapolated": [round(value, 3) for value in share],
        }
        for name, wavelength, level, share in connection.execute(_SQL["unevenness"]).fetchall()
    ]


def _costs(connection: duckdb.DuckDBPyConnection) -> list[list[Any]]:
    """Return case, approach, whether the cost is whole, CPU time, that of one more speed, and evaluations."""
    return [
        [case, approach, whole, *(None if value is None else float(f"{value:.4g}") for value in values)]
        for case, approach, whole, *values in connection.execute(_SQL["costs"]).fetchall()
    ]


def _trains(connection: duckdb.DuckDBPyConnection) -> dict[str, list[Data]]:
    """Return per train its kinds of vehicles: length and distance of axles in a bogie, m, and number."""
    trains: dict[str, list[Data]] = {}
    for train, length, axles, count in connection.execute(_SQL["trains"]).fetchall():
        trains.setdefault(train, []).append({"length": length, "axles": axles, "count": count})
    return trains


def _round(values: NDArray[Any]) -> list[float]:
    return [float(f"{value:.5g}") for value in values]
