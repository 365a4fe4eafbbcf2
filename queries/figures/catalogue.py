"""The figures of a run: which there are, their names, and what they leave out.

Figures carry the numbers of the paper's: 3 unevenness, 4 and 5 rail receptance, 6 and 7 wheel-rail force
(the first soil of the study has the even number, every other the odd one), 8 rail, 9 narrow band, 10 ground.
Beyond the paper's: 11 level against distance, 12 error over speed and band, 13 cost against error.
A file is named by its number and topic, by the soil where it shows a single one, and by every other axis of
the study with more than one value.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType

import duckdb

from queries import answers
from queries.answers import NamedCase
from queries.figures.drawing import Combination, Drawing, FileNames, sample, shown_of
from queries.figures.lines import DISTINCT
from queries.statements import statements

_SQL = statements("queries.figures", "catalogue")
_SOILS, _COMBINATIONS, _OFFSETS, _SPEEDS, _LENGTHS = 4, 3, 12, 6, 3
"""Largest numbers in a figure, or of a study of many cases, with which panels stay readable."""


def are_drawn(connection: duckdb.DuckDBPyConnection, folder: Path) -> bool:
    """Return whether the PNG files of the paper's figures are there."""
    return all((folder / f"{drawing.name}.png").is_file() for drawing in drawings(connection))


def clear(folder: Path, kind: str, drawings: Iterable[Drawing]) -> list[Path]:
    """Remove outdated figures from a folder; return the files of the present ones."""
    files = [folder / f"{drawing.name}.{kind}" for drawing in drawings]
    for old in set(folder.glob(f"figure-[0-9][0-9]-*.{kind}")) - set(files):
        old.unlink()
    for caption in folder.glob("figure-[0-9][0-9]-*.txt"):
        if not any(caption.with_suffix(ending).exists() for ending in (".png", ".svg", ".pdf")):
            caption.unlink()
    return files


def drawings(connection: duckdb.DuckDBPyConnection, every: bool = False) -> list[Drawing]:
    """Return the figures for which there are results, the paper's or `every` one, by number."""
    plan = _Plan(connection)
    figures = [*plan.unevenness(), *plan.receptances(), *plan.forces(), *plan.rail(), *plan.ground()]
    if every:
        figures += [*plan.distance(), *plan.errors(), *plan.cost()]
    return sorted(figures, key=lambda drawing: drawing.name[:9])


class _Plan:
    """The figures of a study; with many cases, those of a sample of soils and combinations."""

    def __init__(self, connection: duckdb.DuckDBPyConnection) -> None:
        self._connection = connection
        self._cases = {(case.soil, _combination(case)): case for case in answers.named_cases(connection)}
        soils = list(dict.fromkeys(soil for soil, _ in self._cases))
        combinations = list(dict.fromkeys(combination for _, combination in self._cases))
        self._names = FileNames(combinations)
        self._soils, self._combinations, self._note = soils, combinations, ""
        if len(self._cases) > answers.MANY_CASES:
            self._soils, self._combinations = sample(soils, _SOILS), sample(combinations, _COMBINATIONS)
            if len(self._soils) < len(soils) or len(self._combinations) < len(combinations):
                self._note = (
                    f"A sample: {len(self._soils)} of {len(soils)} soils and {len(self._combinations)} of "
                    f"{len(combinations)} combinations of track, train, unevenness and speed."
                )
        self._approaches = answers.requested_approaches(connection)
        self._reference = answers.reference(connection)
        self._receivers: dict[str, set[tuple[str, float | None]]] = {}
        for case_id, receiver, offset in connection.execute(_SQL["receivers"]).fetchall():
            self._receivers.setdefault(case_id, set()).add((receiver, offset))

    def _with(self, receiver: str, combination: Combination) -> dict[str, str]:
        """Return the shown cases of a combination that have a receiver, their ids by soil."""
        cases = {soil: self._cases.get((soil, combination)) for soil in self._soils}
        return {
            soil: case.case_id
            for soil, case in cases.items()
            if case and receiver in {name for name, _ in self._receivers.get(case.case_id, ())}
        }

    def _groups(self, receiver: str) -> Iterator[tuple[Combination, dict[str, str]]]:
        """Yield combinations with as many of their cases as fit into a figure."""
        for combination in self._combinations:
            cases = list(self._with(receiver, combination).items())
            for first in range(0, len(cases), _SOILS):
                yield combination, dict(cases[first : first + _SOILS])

    def unevenness(self) -> Iterator[Drawing]:
        rows = self._connection.execute("SELECT DISTINCT unevenness FROM unevenness_bands ORDER BY 1")
        every = [name for (name,) in rows.fetchall()]
        if every:
            shown = sample(every, DISTINCT)
            yield Drawing(
                self._names.name(3, "unevenness"),
                "Unevenness of the rail in one-third octaves of wavelength, dB re 1e-6 m.",
                lambda: _track_plots().unevenness(self._connection, shown),
            ).leaving_out(shown_of(shown, every, "unevenness"))

    def receptances(self) -> Iterator[Drawing]:
        rows = self._connection.execute(_SQL["receptances"]).fetchall()
        tracks = dict.fromkeys(track for _, track, _ in rows)
        for place, soil in enumerate(self._soils):
            for track in tracks:
                speeds = [row[2] for row in rows if row[:2] == (soil, track)]
                if speeds:
                    name = f"{soil}-{track}" if len(tracks) > 1 else soil
                    yield self._receptance(4 + min(place, 1), name, soil, track, speeds)

    def _receptance(self, number: int, name: str, soil: str, track: str, speeds: list[float]) -> Drawing:
        shown = sample(speeds, _SPEEDS)
        return Drawing(
            self._names.name(number, "receptance", name),
            f"Rail receptance under the load, {soil}, {track}: magnitude and phase.",
            lambda: _track_plots().receptance(self._connection, soil, track, shown),
        ).leaving_out(self._note, shown_of(shown, speeds, "speeds"))

    def forces(self) -> Iterator[Drawing]:
        for combination in self._combinations:
            for soil, case_id in self._with("axle-1", combination).items():
                yield self._force(soil, combination, case_id)

    def _force(self, soil: str, combination: Combination, case_id: str) -> Drawing:
        return Drawing(
            self._names.name(6 + min(self._soils.index(soil), 1), "force", soil, combination),
            "Wheel-rail force of the leading and the trailing axle of the leading bogie, "
            f"{soil}: {combination}.",
            lambda: _level_plots().force(self._connection, soil, case_id, self._approaches),
        ).leaving_out(self._note)

    def rail(self) -> Iterator[Drawing]:
        with_lines = {case_id for (case_id,) in self._connection.execute(_SQL["with-lines"]).fetchall()}
        for combination, cases in self._groups("rail"):
            yield self._rail(combination, cases)
            # A study may leave narrow-band lines out of the database.
            of_lines = {soil: case_id for soil, case_id in cases.items() if case_id in with_lines}
            if of_lines:
                yield self._narrow_band(combination, of_lines)

    def _rail(self, combination: Combination, cases: Mapping[str, str]) -> Drawing:
        return Drawing(
            self._names.name(8, "rail", None, combination),
            f"Rail velocity in one-third octaves, {', '.join(cases)}: {combination}.",
            lambda: _level_plots().rail(self._connection, cases, self._approaches),
        ).leaving_out(self._note)

    def _narrow_band(self, combination: Combination, cases: Mapping[str, str]) -> Drawing:
        others = [name for name in self._approaches if name != self._reference]
        shown = [self._reference, *others[:1]]
        lengths = self._connection.execute(_SQL["vehicle-lengths"], [next(iter(cases.values()))]).fetchall()
        passing = {length: count for length, count in lengths[:_LENGTHS]}
        return Drawing(
            self._names.name(9, "narrow-band", None, combination),
            f"Narrow-band spectrum of the rail velocity, {', '.join(cases)}: {combination}. Vertical lines: "
            "multiples of the speed over the lengths of the vehicles.",
            lambda: _spectrum_plots().narrow_band(
                self._connection, cases, shown, combination.speed_kmh, passing
            ),
        ).leaving_out(
            self._note,
            shown_of(shown, self._approaches, "approaches"),
            shown_of(list(passing), lengths, "lengths of vehicles"),
        )

    def ground(self) -> Iterator[Drawing]:
        for combination, cases in self._groups("ground"):
            yield self._ground(combination, cases)

    def _ground(self, combination: Combination, cases: Mapping[str, str]) -> Drawing:
        places = set().union(*(self._receivers[case_id] for case_id in cases.values()))
        offsets = sorted(offset for receiver, offset in places if receiver == "ground" and offset is not None)
        shown = sample(offsets, _OFFSETS)
        return Drawing(
            self._names.name(10, "ground", None, combination),
            f"Ground velocity in one-third octaves at each distance from the track, {', '.join(cases)}: "
            f"{combination}.",
            lambda: _level_plots().ground(self._connection, cases, self._approaches, shown),
        ).leaving_out(self._note, shown_of(shown, offsets, "distances"))

    def distance(self) -> Iterator[Drawing]:
        for combination, cases in self._groups("ground"):
            yield self._distance(combination, cases)

    def _distance(self, combination: Combination, cases: Mapping[str, str]) -> Drawing:
        return Drawing(
            self._names.name(11, "distance", None, combination),
            f"Ground velocity against distance, all bands together and single octaves, {', '.join(cases)}: "
            f"{combination}.",
            lambda: _level_plots().distance(self._connection, cases, self._approaches),
        ).leaving_out(self._note)

    def errors(self) -> Iterator[Drawing]:
        rows = self._connection.execute(_SQL["compared-on-ground"]).fetchall()
        for approach in answers.in_order(name for (name,) in rows):
            yield self._error(approach)

    def _error(self, approach: str) -> Drawing:
        return Drawing(
            self._names.name(12, "error", approach),
            f"Mean size of the error of {approach} against {self._reference} on the ground, over all cases "
            "of a soil.",
            lambda: _error_plots().error_map(self._connection, self._soils, approach, self._reference),
        ).leaving_out(self._note)

    def cost(self) -> Iterator[Drawing]:
        row = self._connection.execute(
            "SELECT min(place) FROM tradeoff WHERE quantity = 'velocity'"
        ).fetchone()
        places = {"ground": "on the ground", "rail": "of the rail"}
        if row and row[0] in places:
            place = row[0]
            yield Drawing(
                self._names.name(13, "cost"),
                f"Mean size of the error of the velocity {places[place]} against processor time, a point per "
                "case and approach.",
                lambda: _error_plots().cost(self._connection, self._approaches, place),
            )


def _combination(case: NamedCase) -> Combination:
    return Combination(case.track, case.train, case.unevenness, case.speed_kmh)


def _level_plots() -> ModuleType:
    """Return the module; importing it loads the plotting library, which only drawing needs."""
    from queries.figures import level_plots

    return level_plots


def _spectrum_plots() -> ModuleType:
    from queries.figures import spectrum_plots

    return spectrum_plots


def _track_plots() -> ModuleType:
    from queries.figures import track_plots

    return track_plots


def _error_plots() -> ModuleType:
    from queries.figures import error_plots

    return error_plots
