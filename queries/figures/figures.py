"""Which figures a run gets, what they are called, and their files under DIR/figures.

Figures carry the numbers of the paper's: 3 unevenness, 4 and 5 rail receptance, 6 and 7 wheel-rail force
(the first soil of the study has the even number, every other the odd one), 8 rail, 9 narrow band, 10 ground.
Beyond the paper's: 11 level against distance, 12 error over speed and band, 13 cost against error.
A file is named by its number and topic, by the soil where it shows a single one, and by every other axis of
the study with more than one value.
"""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import duckdb
import numpy as np
from numpy.typing import NDArray

from queries.answers import compare
from queries.answers.combination import Combination, columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PASSING = 8
"""Multiples of the passing frequency of vehicles that a spectrum is marked with."""
_SOILS, _COMBINATIONS, _OFFSETS, _SPEEDS = 4, 3, 6, 6
"""At most so many are shown of a study of many cases; panels of one figure stay readable up to here."""

Item = TypeVar("Item")


@dataclass(frozen=True)
class Drawing:
    """A figure to be drawn: file name without ending, what it shows, and how to draw it."""

    name: str
    caption: str
    draw: Callable[[], "Figure"]


def write(drawing: Drawing, file: Path, kind: str) -> None:
    """Draw a figure into a file of a kind: png, svg or pdf."""
    from queries.figures import appearance

    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    partial = file.with_name(f"{file.name}.partial")
    # Half the time of writing a PNG goes into its last tenth of size.
    options: dict[str, Any] = {"pil_kwargs": {"compress_level": 1}} if kind == "png" else {}
    figure = drawing.draw()
    figure.savefig(partial, format=kind, metadata=metadata, **options)
    partial.replace(file)
    appearance.take_back(figure)


def drawn(connection: duckdb.DuckDBPyConnection, folder: Path) -> bool:
    """Return whether the PNG files of all figures are there."""
    return all((folder / f"{drawing.name}.png").is_file() for drawing in drawings(connection))


def drawings(connection: duckdb.DuckDBPyConnection, every: bool = False) -> list[Drawing]:
    """Return the figures that the results allow, the paper's or `every` one, in order of their numbers."""
    found = connection.execute("SELECT soil, track, train, unevenness, speed_kmh FROM cases").fetchall()
    soils = _unique(row[0] for row in found)
    combinations = _unique(Combination(*row[1:]) for row in found)
    shown = ""
    if len(found) > compare.MANY_CASES:
        all_soils, all_combinations = soils, combinations
        soils, combinations = sample(soils, _SOILS), sample(combinations, _COMBINATIONS)
        shown = (
            f" A sample: {len(soils)} of {len(all_soils)} soils and {len(combinations)} of "
            f"{len(all_combinations)} "
            "combinations of track, train, unevenness and speed."
        )
    names = _Names(_unique(row[1:] for row in found))
    plan = [
        *_unevenness(connection, names),
        *_receptances(connection, names, soils),
        *_cases(connection, names, soils, combinations),
    ]
    if every:
        plan += _worth(connection, names, soils, combinations)
    return [
        Drawing(drawing.name, drawing.caption + shown, drawing.draw)
        for drawing in sorted(plan, key=lambda each: each.name[:9])
    ]


def sample(items: Sequence[Item], most: int) -> list[Item]:
    """Return at most so many items, evenly spread, the first and the last among them."""
    if len(items) <= most:
        return list(items)
    return [items[round(place)] for place in np.linspace(0, len(items) - 1, most)]


_LONGEST_NAME = 200
"""Characters of a file's name, without what tells it from equal ones and its ending; systems take 255."""


class _Names:
    """Gives every figure a file name of plain letters that no other one has."""

    def __init__(self, combinations: list[Any]) -> None:
        self._varying = [number for number in range(4) if len({row[number] for row in combinations}) > 1]
        self._taken: set[str] = set()

    def name(
        self, number: int, topic: str, soil: str | None = None, combination: Combination | None = None
    ) -> str:
        parts = [f"figure-{number:02d}-{topic}", *([soil] if soil is not None else [])]
        if combination is not None:
            values = (
                combination.track,
                combination.train,
                combination.unevenness,
                f"{combination.speed_kmh:g}-kmh",
            )
            parts += [values[place] for place in self._varying]
        base = "-".join(re.sub(r"[^a-z0-9]+", "-", part.lower()).strip("-") for part in parts)[:_LONGEST_NAME]
        free = next(name for name in self._candidates(base) if name not in self._taken)
        self._taken.add(free)
        return free

    @staticmethod
    def _candidates(base: str) -> Iterator[str]:
        yield base
        number = 2
        while True:
            yield f"{base}-{number}"
            number += 1


def _unevenness(connection: duckdb.DuckDBPyConnection, names: _Names) -> list[Drawing]:
    found = _unique(
        row[0] for row in connection.execute("SELECT unevenness FROM unevenness_bands").fetchall()
    )
    if not found:
        return []
    shown = sample(found, len("osv^Dv<"))
    return [
        Drawing(
            names.name(3, "unevenness"),
            "Unevenness of the rail in one-third octaves of wavelength, dB re 1e-6 m.",
            _bind(lambda plots: plots.unevenness, connection, shown),
        )
    ]


def _receptances(connection: duckdb.DuckDBPyConnection, names: _Names, soils: list[str]) -> list[Drawing]:
    found = connection.execute(
        "SELECT DISTINCT soil, track, speed_kmh FROM receptances ORDER BY ALL"
    ).fetchall()
    tracks = _unique(row[1] for row in found)
    plan = []
    for place, soil in enumerate(soils):
        for track in tracks:
            speeds = sample([row[2] for row in found if row[:2] == (soil, track)], _SPEEDS)
            if speeds:
                plan.append(
                    Drawing(
                        names.name(
                            4 + min(place, 1), "receptance", f"{soil}-{track}" if len(tracks) > 1 else soil
                        ),
                        f"Rail receptance under the load, {soil}, {track}: magnitude and phase.",
                        _bind(lambda plots: plots.receptance, connection, soil, track, speeds),
                    )
                )
    return plan


def _cases(
    connection: duckdb.DuckDBPyConnection,
    names: _Names,
    soils: list[str],
    combinations: list[Combination],
) -> list[Drawing]:
    approaches, against = compare.approaches(connection), compare.reference(connection)
    others = [name for name in approaches if name != against]
    lines = set(  # a study may keep narrow-band lines out of the database
        connection.execute(
            "SELECT DISTINCT soil, track, train, unevenness, speed_kmh FROM series JOIN cases USING "
            "(case_id) "
            "WHERE receiver = 'rail'"
        ).fetchall()
    )
    plan = []
    for case in combinations:
        about = f"{case.train} on {case.track}, {case.unevenness}, {case.speed_kmh:g} km/h"
        receivers = columns(
            connection,
            "SELECT DISTINCT soil, receiver, offset_m FROM levels WHERE track = $1 AND train = $2 AND "
            "unevenness = $3 "
            "AND speed_kmh = $4 ORDER BY offset_m",
            [case.track, case.train, case.unevenness, case.speed_kmh],
        )
        there = list(zip(receivers["soil"], receivers["receiver"], receivers["offset_m"], strict=True))
        for place, soil in enumerate(soils):
            if any(row[:2] == (soil, "axle-1") for row in there):
                plan.append(
                    Drawing(
                        names.name(6 + min(place, 1), "force", soil, case),
                        f"Wheel-rail force of the leading and the trailing axle of the leading bogie, "
                        f"{soil}: {about}.",
                        _bind(lambda plots: plots.force, connection, soil, case, approaches),
                    )
                )
        for group in (soils[start : start + _SOILS] for start in range(0, len(soils), _SOILS)):
            on_rail = [soil for soil in group if any(row[:2] == (soil, "rail") for row in there)]
            on_ground = [soil for soil in group if any(row[:2] == (soil, "ground") for row in there)]
            if on_rail:
                plan.append(
                    Drawing(
                        names.name(8, "rail", None, case),
                        f"Rail velocity in one-third octaves: {about}.",
                        _bind(lambda plots: plots.rail, connection, on_rail, case, approaches),
                    )
                )
            with_lines = [
                soil
                for soil in on_rail
                if (soil, case.track, case.train, case.unevenness, case.speed_kmh) in lines
            ]
            if with_lines:
                plan.append(
                    Drawing(
                        names.name(9, "narrow-band", None, case),
                        f"Narrow-band spectrum of the rail velocity: {about}.",
                        _bind(lambda _: _narrow_band, connection, with_lines, case, (against, *others[:1])),
                    )
                )
            if on_ground:
                offsets = sample(_unique(float(row[2]) for row in there if row[1] == "ground"), _OFFSETS)
                plan.append(
                    Drawing(
                        names.name(10, "ground", None, case),
                        f"Ground velocity in one-third octaves at each distance from the track: {about}.",
                        _bind(lambda plots: plots.ground, connection, on_ground, case, approaches, offsets),
                    )
                )
    return plan


def _worth(
    connection: duckdb.DuckDBPyConnection, names: _Names, soils: list[str], combinations: list[Combination]
) -> list[Drawing]:
    """Return the figures of level against distance, of errors, and of costs."""
    from queries.figures import error_plots

    row = connection.execute("SELECT count(*) FROM bands WHERE receiver = 'ground'").fetchone()
    on_ground = bool(row and row[0])
    approaches, against = compare.approaches(connection), compare.reference(connection)
    compared = {row[0] for row in connection.execute("SELECT DISTINCT approach FROM accuracy").fetchall()}
    plan = [
        Drawing(
            names.name(11, "distance", None, case),
            f"Ground velocity against distance: {case.train} on {case.track}, {case.unevenness}, "
            f"{case.speed_kmh:g} km/h.",
            _bind(lambda _: error_plots.distance, connection, soils, case, approaches),
        )
        for case in combinations
        if on_ground
    ]
    plan += [
        Drawing(
            names.name(12, "error", approach),
            f"Mean error of {approach} on the ground, all cases: level minus that of {against}.",
            _bind(lambda _: error_plots.error_map, connection, soils, approach, against),
        )
        for approach in compare.in_order(compared)
        if on_ground
    ]
    if compared:
        plan.append(
            Drawing(
                names.name(13, "cost"),
                "Mean size of the error against processor time, a point per case and approach.",
                _bind(lambda _: error_plots.cost, connection, approaches),
            )
        )
    return plan


def _narrow_band(
    connection: duckdb.DuckDBPyConnection, soils: Sequence[str], case: Combination, approaches: Sequence[str]
) -> "Figure":
    """Draw the rail's narrow-band spectra by some approaches, the reference first."""
    from queries.figures import plots

    found = connection.execute(
        "SELECT soil, approach, min(series_id) FROM series "
        "JOIN current_units USING (source, unit_id, case_id, approach) JOIN cases USING (case_id) "
        "WHERE track = $1 AND train = $2 AND unevenness = $3 AND speed_kmh = $4 AND receiver = 'rail' "
        "AND contribution = 'dynamic' AND averaging = 'line' GROUP BY soil, approach",
        [case.track, case.train, case.unevenness, case.speed_kmh],
    ).fetchall()
    numbers = {(soil, approach): series for soil, approach, series in found}
    spectra: dict[str, dict[str, tuple[NDArray[Any], NDArray[Any]]]] = {}
    for soil, approach in ((soil, approach) for soil in soils for approach in approaches):
        data = columns(
            connection,
            "SELECT frequency_hz, value FROM psd_lines WHERE series_id = $1 ORDER BY frequency_hz",
            [numbers.get((soil, approach), -1)],
        )
        if data["frequency_hz"].size:
            spectra.setdefault(soil, {})[approach] = (data["frequency_hz"], data["value"])
    ends = connection.execute("SELECT min(band_hz), max(band_hz) FROM bands").fetchone() or (1.0, 100.0)
    row = connection.execute("SELECT max(length_m) FROM vehicles WHERE train = $1", [case.train]).fetchone()
    first = case.speed_kmh / 3.6 / row[0] if row and row[0] else math.inf
    passing = [n * first for n in range(1, _PASSING + 1) if ends[0] <= n * first <= ends[1]]
    return plots.narrow_band(spectra, (ends[0], ends[1]), passing)


def _bind(which: Callable[[ModuleType], Callable[..., "Figure"]], *given: Any) -> Callable[[], "Figure"]:
    """Fix what a plot is drawn from now; the plotting library is loaded when it is drawn."""

    def draw() -> "Figure":
        from queries.figures import plots

        return which(plots)(*given)

    return draw


def _unique(items: Any) -> list[Any]:
    """Return each item once, in the order of its first appearance."""
    return list(dict.fromkeys(items))
