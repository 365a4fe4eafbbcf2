"""What the report draws: levels, lines, receptances and costs as compact arrays, all from the database.

Levels go as whole hundredths of a decibel. Narrow-band spectra go line by line while they fit into their
share of the page; beyond it each is thinned to the smallest and the largest line of every bin of frequency,
which keeps peaks and dips where they are, and the page says so.
"""

import base64
import math
from dataclasses import dataclass
from typing import Any

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries import compare
from queries.lines import approach_line
from queries.table import band

LINES_BYTES = 3_000_000
"""Share of the page for narrow-band spectra, before it is written as text."""
MOST_BINS, FEW_BINS, LEAST_BINS = 1000, 300, 100
"""Bins of a thinned spectrum: at most, so few that only dynamic ones are shown, or fewer cases."""
_CASES_AT_ONCE = 2
"""Cases whose spectra are read by one query."""
CONTRIBUTIONS = ("dynamic", "quasi-static", "total")
_NONE = -32768
_SYMBOLS = {"o": "circle", "s": "square", "D": "diamond", "^": "triangle-up", "v": "triangle-down", "x": "x"}
_AXES = ("soil", "track", "train", "unevenness", "speed_kmh")

Data = dict[str, Any]


@dataclass(frozen=True)
class _Sizes:
    cases: int
    approaches: int
    receivers: int
    bands: int


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
        "lines": _lines(connection, sizes),
        "receptances": _receptances(connection),
        "unevenness": _unevenness(connection),
        "costs": _costs(connection),
        "trains": _trains(connection),
    }


def _number(connection: duckdb.DuckDBPyConnection, approaches: list[str]) -> _Sizes:
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
    return _Sizes(*(int(row[0]) for row in counts))


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


def _levels(connection: duckdb.DuckDBPyConnection, sizes: _Sizes) -> str:
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
    packed = np.full(math.prod(shape), _NONE, dtype="<i2")
    packed[np.asarray(found["place"])] = _hundredths(found["level_db"])
    return _text(packed)


def _lines(connection: duckdb.DuckDBPyConnection, sizes: _Sizes) -> Data:
    """Return narrow-band spectra, all lines of each or the extremes of bins, with what was done to them.

    Spectra of one case share their frequencies; a spectrum is numbered by (case, approach, contribution,
    receiver), and lies in the packed array where `at` says.
    """
    which = (
        "series JOIN current_units USING (source, unit_id, case_id, approach) JOIN page_cases USING "
        "(case_id) "
        "JOIN page_approaches USING (approach) JOIN page_contributions USING (contribution) "
        "JOIN page_receivers ON page_receivers.quantity = series.quantity "
        "AND page_receivers.receiver = series.receiver "
        "AND page_receivers.offset_m IS NOT DISTINCT FROM series.offset_m "
        "WHERE averaging = 'line' AND series.receiver IN ('rail', 'ground', 'axle-1', 'axle-2')"
    )
    connection.execute(
        "CREATE OR REPLACE TEMP TABLE page_series AS SELECT series_id, page_cases.number AS case_number, "
        "contribution, "
        f"(page_cases.number * {sizes.approaches} + page_approaches.number) * {len(CONTRIBUTIONS)} "
        f"+ page_contributions.number AS place, page_receivers.number AS receiver FROM {which}"
    )
    connection.execute(
        "CREATE OR REPLACE TEMP TABLE page_grids AS SELECT case_number, min(frequency_hz) AS first, "
        "max(frequency_hz) AS last, count(*) / count(DISTINCT series_id) AS lines "
        "FROM psd_lines JOIN (SELECT case_number, min(series_id) AS series_id FROM page_series "
        "GROUP BY case_number) USING (series_id) WHERE frequency_hz > 0 GROUP BY case_number"
    )
    row = connection.execute(
        "SELECT (SELECT count(*) FROM page_series), (SELECT count(*) FROM page_series WHERE contribution = "
        "'dynamic'), (SELECT coalesce(max(lines), 0) FROM page_grids), (SELECT count(*) FROM page_grids)"
    ).fetchone()
    every, dynamic, most_lines, cases = map(int, row or (0, 0, 0, 0))
    plan = _Thinning.of(every, dynamic, most_lines, cases)
    return plan.said() | {"spectra": _packed(connection, plan, sizes)}


@dataclass(frozen=True)
class _Thinning:
    """How narrow-band spectra are made to fit: bins (0: every line), contributions, and cases."""

    bins: int
    dynamic_only: bool
    cases: int
    of_cases: int
    lines: int

    @staticmethod
    def of(every: int, dynamic: int, lines: int, cases: int) -> "_Thinning":
        if every * lines * 2 <= LINES_BYTES:
            return _Thinning(0, False, cases, cases, lines)
        bins = LINES_BYTES // (4 * max(every, 1))
        if bins >= FEW_BINS:
            return _Thinning(min(bins, MOST_BINS), False, cases, cases, lines)
        bins = LINES_BYTES // (4 * max(dynamic, 1))
        if bins >= LEAST_BINS:
            return _Thinning(min(bins, MOST_BINS), True, cases, cases, lines)
        shown = max(1, LINES_BYTES * cases // (4 * LEAST_BINS * max(dynamic, 1)))
        return _Thinning(LEAST_BINS, True, shown, cases, lines)

    def said(self) -> Data:
        """Return the plan as the page tells it."""
        return {
            "bins": self.bins,
            "dynamic_only": self.dynamic_only,
            "cases": self.cases,
            "of_cases": self.of_cases,
            "lines": self.lines,
        }


def _packed(connection: duckdb.DuckDBPyConnection, plan: _Thinning, sizes: _Sizes) -> list[Data]:
    """Return the spectra of each shown case: frequencies, and levels of all lines or extremes of bins."""
    numbers = [
        row[0] for row in connection.execute("SELECT case_number FROM page_grids ORDER BY 1").fetchall()
    ]
    if plan.cases < len(numbers):
        numbers = [numbers[round(at)] for at in np.linspace(0, len(numbers) - 1, plan.cases)]
    chosen = "case_number = $1" + (" AND contribution = 'dynamic'" if plan.dynamic_only else "")
    level = "decibel(CASE WHEN page_receivers.quantity = 'wheel_rail_force' THEN {0} ELSE {0} * 1e18 END)"
    if plan.bins:
        position = f"least({plan.bins - 1}, floor({plan.bins} * ln(frequency_hz / first) / ln(last / first)))"
        select = (
            f"SELECT case_number, place, receiver, {position}::INTEGER AS spot, min(value) AS low, "
            "max(value) AS high"
        )
        group = "GROUP BY ALL"
    else:
        select = "SELECT case_number, place, receiver, frequency_hz AS spot, value AS low, value AS high"
        group = ""
    query = (
        f"WITH lines AS ({select} FROM psd_lines JOIN page_series USING (series_id) "
        f"JOIN page_grids USING (case_number) WHERE {chosen} AND frequency_hz > 0 {group}) "
        "SELECT place, lines.receiver, spot, first, last, "
        f"{level.format('low')} AS low, {level.format('high')} AS high FROM lines "
        "JOIN page_receivers ON page_receivers.number = lines.receiver JOIN page_grids USING (case_number)"
    )
    spectra = []
    for number in numbers:  # one after the other: their lines would take ten times the memory of the page
        found = connection.execute(query, [number]).fetchnumpy()
        columns = {name: _filled(array) for name, array in found.items()}
        spectra.append({"case": int(number), **_spectra_of_case(columns, plan, sizes)})
    return spectra


def _spectra_of_case(columns: dict[str, NDArray[Any]], plan: _Thinning, sizes: _Sizes) -> Data:
    key = columns["place"].astype(np.int64) * sizes.receivers + columns["receiver"].astype(np.int64)
    ids, inverse = np.unique(key, return_inverse=True)
    at = columns["spot"]
    if plan.bins:
        first, last = columns["first"][0], columns["last"][0]
        frequency = first * (last / first) ** ((np.arange(plan.bins) + 0.5) / plan.bins)
        packed = np.full((ids.size, plan.bins, 2), _NONE, dtype="<i2")
        packed[inverse, at.astype(int), 0] = _hundredths(columns["low"])
        packed[inverse, at.astype(int), 1] = _hundredths(columns["high"])
    else:
        frequency, place = np.unique(at, return_inverse=True)
        packed = np.full((ids.size, frequency.size), _NONE, dtype="<i2")
        packed[inverse, place] = _hundredths(columns["high"])
    return {
        "places": (ids // sizes.receivers % (sizes.approaches * len(CONTRIBUTIONS))).tolist(),
        "receivers": (ids % sizes.receivers).tolist(),
        "frequency": [float(f"{value:.6g}") for value in frequency],
        "levels": _text(packed),
    }


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


def _filled(array: Any) -> NDArray[Any]:
    if isinstance(array, np.ma.MaskedArray):
        return np.asarray(array.filled(np.nan if array.dtype.kind == "f" else 0))
    return np.asarray(array)


def _hundredths(level: Any) -> NDArray[np.int16]:
    value = np.round(100.0 * np.asarray(_filled(level), dtype=float))
    return np.where(np.isfinite(value), np.clip(value, _NONE + 1, -_NONE - 1), _NONE).astype("<i2")


def _rounded(values: NDArray[Any]) -> list[float]:
    return [float(f"{value:.5g}") for value in values]


def _text(array: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
