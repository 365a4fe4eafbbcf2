"""What the report draws: levels, spectra, receptances and costs as compact arrays, all from the database."""

import math
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries.answers import compare
from queries.answers.table import band
from queries.figures.lines import approach_line
from queries.report import page_spectra
from queries.report.packing import NONE, hundredths, text
from queries.report.page_spectra import CONTRIBUTIONS, Sizes

_SYMBOLS = {"o": "circle", "s": "square", "D": "diamond", "^": "triangle-up", "v": "triangle-down", "x": "x"}
_AXES = ("soil", "track", "train", "unevenness", "speed_kmh")

Data = dict[str, Any]


def data(connection: duckdb.DuckDBPyConnection) -> Data:
    """Return everything that the page draws, ready for JSON."""
    approaches = compare.approaches(connection)
    sizes = _number(connection, approaches)
    axes, cases = _cases(connection)
    bands = [
        row[0] for row in connection.execute("SELECT band_hz FROM page_bands ORDER BY number").fetchall()
    ]
    return {
        "reference": compare.reference(connection),
        "approaches": [_style(name) for name in approaches],
        "axes": axes,
        "cases": cases,
        "contributions": CONTRIBUTIONS,
        "receivers": _receivers(connection),
        "bands": bands,
        "band_names": [band(value) for value in bands],
        "levels": _levels(connection, sizes),
        "receptances": _receptances(connection),
        "unevenness": _unevenness(connection),
        "costs": _costs(connection),
        "trains": _trains(connection),
        "lines": page_spectra.spectra(connection, sizes),  # last: it fills what DuckDB may hold
    }


def _number(connection: duckdb.DuckDBPyConnection, approaches: list[str]) -> Sizes:
    """Give cases, approaches, receivers and bands their numbers on the page, in tables of this connection."""
    contributions = ", ".join(f"('{name}', {number})" for number, name in enumerate(CONTRIBUTIONS))
    place = "CASE receiver WHEN 'rail' THEN 0 WHEN 'ground' THEN 1 ELSE 2 END"
    axle = "try_cast(replace(receiver, 'axle-', '') AS INTEGER)"
    for statement in (
        "page_cases AS SELECT case_id, (row_number() OVER (ORDER BY rowid) - 1)::INTEGER AS number FROM "
        "cases",
        "page_receivers AS SELECT quantity, receiver, offset_m, (row_number() OVER (ORDER BY quantity = "
        f"'wheel_rail_force', {place}, abs(offset_m), offset_m, {axle}, receiver) - 1)::INTEGER AS number "
        "FROM (SELECT DISTINCT quantity, receiver, offset_m FROM bands)",
        "page_bands AS SELECT band_hz, (row_number() OVER (ORDER BY band_hz) - 1)::INTEGER AS number "
        "FROM (SELECT DISTINCT band_hz FROM bands)",
        f"page_contributions AS SELECT * FROM (VALUES {contributions}) AS t(contribution, number)",
        "page_approaches AS SELECT unnest($1) AS approach, generate_subscripts($1, 1)::INTEGER - 1 AS number",
    ):
        given = [approaches] if "$1" in statement else []
        connection.execute(f"CREATE OR REPLACE TEMP TABLE {statement}", given)
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
    """Return the values of each axis in the order of the study, and the places of each case."""
    rows = connection.execute(f"SELECT {', '.join(_AXES)} FROM cases ORDER BY rowid").fetchall()
    columns = list(zip(*rows, strict=True)) or [()] * len(_AXES)
    axes = {name: list(dict.fromkeys(column)) for name, column in zip(_AXES, columns, strict=True)}
    axes["speed_kmh"].sort()
    places = {name: {value: place for place, value in enumerate(values)} for name, values in axes.items()}
    return axes, [[places[name][value] for name, value in zip(_AXES, row, strict=True)] for row in rows]


def _receivers(connection: duckdb.DuckDBPyConnection) -> list[Data]:
    rows = connection.execute(
        "SELECT quantity, receiver, offset_m FROM page_receivers ORDER BY number"
    ).fetchall()
    return [
        {"quantity": quantity, "receiver": receiver, "offset_m": offset, "label": _place(receiver, offset)}
        for quantity, receiver, offset in rows
    ]


def _place(receiver: str, offset: float | None) -> str:
    if receiver == "ground":
        return f"ground at {offset:g} m"
    return receiver.replace("axle-", "axle ") + (" (leading)" if receiver == "axle-1" else "")


def _levels(connection: duckdb.DuckDBPyConnection, sizes: Sizes) -> str:
    """Return levels over (case, approach, contribution, receiver, band)."""
    shape = (sizes.cases, sizes.approaches, len(CONTRIBUTIONS), sizes.receivers, sizes.bands)
    found = connection.execute(
        f"SELECT (((page_cases.number * {shape[1]} + page_approaches.number) * {shape[2]} "
        f"+ page_contributions.number) * {shape[3]} + page_receivers.number)::BIGINT * {shape[4]} "
        "+ page_bands.number AS place, level_db FROM levels JOIN page_cases USING (case_id) "
        "JOIN page_approaches USING (approach) JOIN page_contributions USING (contribution) "
        "JOIN page_bands USING (band_hz) JOIN page_receivers ON page_receivers.quantity = levels.quantity "
        "AND page_receivers.receiver = levels.receiver "
        "AND page_receivers.offset_m IS NOT DISTINCT FROM levels.offset_m "
        "WHERE averaging = 'line' AND level_db IS NOT NULL"
    ).fetchnumpy()
    packed = np.full(math.prod(shape), NONE, dtype="<i2")
    packed[np.asarray(found["place"])] = hundredths(found["level_db"])
    return text(packed)


def _receptances(connection: duckdb.DuckDBPyConnection) -> list[Data]:
    """Return magnitude [1e-9 m/N] and phase [rad] of the rail's receptance per soil, track and speed."""
    found = connection.execute(
        # Trains with other distances between axles have units of their own: one value per frequency.
        "WITH ends AS (SELECT min(band_hz) * 10 ** -0.05 AS lowest, max(band_hz) * 10 ** 0.05 AS highest "
        "FROM page_bands), single AS (SELECT soil, track, speed_kmh, frequency_hz, "
        "arg_min(receptance_re, unit_id) AS re, arg_min(receptance_im, unit_id) AS im FROM receptances, ends "
        "WHERE frequency_hz > 0 AND coalesce(frequency_hz BETWEEN lowest AND highest, true) GROUP BY ALL) "
        "SELECT soil, track, speed_kmh, list(frequency_hz ORDER BY frequency_hz), "
        "list(re ORDER BY frequency_hz), list(im ORDER BY frequency_hz) FROM single GROUP BY ALL ORDER BY ALL"
    ).fetchall()
    curves = []
    for soil, track, speed, frequency, real, imaginary in found:
        value = np.array(real) + 1j * np.array(imaginary)
        curves.append(
            {
                "soil": soil,
                "track": track,
                "speed_kmh": speed,
                "frequency": _rounded(np.array(frequency)),
                "magnitude": _rounded(1e9 * np.abs(value)),
                "phase": _rounded(np.unwrap(np.angle(value))),
            }
        )
    return curves


def _unevenness(connection: duckdb.DuckDBPyConnection) -> list[Data]:
    found = connection.execute(
        "SELECT unevenness, list(wavelength_m ORDER BY wavelength_m), "
        "list(decibel(mean_square_m2 * 1e12) ORDER BY wavelength_m), "
        "list(coalesce(extrapolated_share, 0) ORDER BY wavelength_m) FROM unevenness_bands "
        "GROUP BY unevenness, unevenness_id ORDER BY unevenness"
    ).fetchall()
    return [
        {
            "name": name,
            "wavelength": _rounded(np.array(wavelength)),
            "level": [None if value is None else round(value, 2) for value in level],
            "extrapolated": [round(value, 3) for value in share],
        }
        for name, wavelength, level, share in found
    ]


def _costs(connection: duckdb.DuckDBPyConnection) -> list[list[Any]]:
    """Return case, approach, whether the cost is whole, CPU time, that of one more speed, and evaluations."""
    rows = connection.execute(
        "SELECT page_cases.number, page_approaches.number, missing_units = 0, cpu_s, marginal_speed_cpu_s, "
        "evaluations FROM runtime JOIN page_cases USING (case_id) JOIN page_approaches USING (approach) "
        "ORDER BY ALL"
    ).fetchall()
    return [
        [case, approach, whole, *(None if value is None else float(f"{value:.4g}") for value in values)]
        for case, approach, whole, *values in rows
    ]


def _trains(connection: duckdb.DuckDBPyConnection) -> dict[str, Data]:
    """Return per train the distances whose passing marks a spectrum, m."""
    rows = connection.execute(
        "SELECT train, any_value(length_m), any_value(bogie_spacing_m), any_value(axle_spacing_m) FROM "
        "vehicles "
        "WHERE vehicle = 1 GROUP BY train"
    ).fetchall()
    return {
        train: {"vehicle": length, "bogies": bogies, "axles": axles} for train, length, bogies, axles in rows
    }


def _rounded(values: NDArray[Any]) -> list[float]:
    return [float(f"{value:.5g}") for value in values]
