"""Section 4: time and memory against the size of a study, axis by axis."""

import tempfile
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.figures import Figure, slope, time_call
from benchmarks.peers.fourier_grid import OFFSETS
from benchmarks.runs import process, soils
from benchmarks.runs.process import RunCost
from benchmarks.runs.study_text import PAPER_SOILS, study
from benchmarks.sections.transfer import FIT_TOLERANCE, SOILS, TRACK, wavenumbers
from benchmarks.sizes import Size
from railvib import library
from railvib.numerics.third_octaves import midbands
from railvib.parameters.units import KMH
from railvib.psd.lines import lines
from railvib.soil._kernels.strip import strip_compliances
from railvib.soil.rational_fit import fit_flexibility

SECTION = "growth"
SLOPE = 1.05
"""Linear, with a margin for the scatter of a few samples."""
RATIOS = {"speeds": 2.5, "offsets": 2.0, "layers": 1.3}
"""Targets for the cost of the largest size over the smallest; for layers, of every doubling."""
_SLOPE_ROUNDS = 3
"""Rounds that suffice for a slope."""
_SPEEDS_KMH = (80.0, 232.0)


def measure(size: Size) -> Iterator[Figure]:
    """Yield total and computing seconds and memory at every value of every axis, and their slopes."""
    yield from _wavenumbers(size)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        run(size, "speeds", 1, home / "first")  # compiles the kernels
        for axis, values in size.growth.items():
            if axis == "wavenumbers":
                continue
            runs: list[list[RunCost]] = [[] for _ in values]
            for turn in range(size.rounds if axis in RATIOS else min(size.rounds, _SLOPE_ROUNDS)):
                for i, value in enumerate(values):
                    if turn == 0 or i in (0, len(values) - 1):
                        runs[i].append(run(size, axis, value, home / f"{axis}-{i}-{turn}"))
                        process.truncate(runs[i][-1].directory)
            yield from _figures(axis, values, runs)
            if axis == "speeds":
                yield from _marginal(size, values, runs)


def run(size: Size, axis: str, value: float, directory: Path) -> RunCost:
    """Run the study with this value on one axis and a single thing on every other."""
    # Without workers all is computed in one process, and a second core hides nothing.
    workers = int(value) if axis == "workers" else 0
    return process.run(text(size, axis, value), directory, workers)


def text(size: Size, axis: str, value: float) -> str:
    """Return the study with this value on one axis and a single thing on every other."""
    keys: dict[str, Any] = {"bands_hz": size.bands_hz, "offsets_m": size.offsets_m}
    count = int(value)
    match axis:
        case "frequencies":
            keys["bands_hz"] = (size.bands_hz[0], value)
        case "offsets":
            keys["offsets_m"] = np.linspace(0.0, 100.0, count).round(6).tolist()
        case "layers":
            keys |= {"soils": ["graded"], "definitions": {"soil.graded": soils.graded_soil(count)}}
        case "vehicles":
            group = {"vehicle": "regina", "number": count}
            keys |= {"trains": ["long"], "definitions": {"train.long": group}}
        case "trains":
            names = [f"train-{i}" for i in range(count)]
            keys |= {"trains": names, "definitions": _trains(names)}
        case "soils":
            names = [f"soil-{i}" for i in range(count)]
            definitions = {
                f"soil.{name}": soils.graded_soil(3, 1.0 + 0.1 * i) for i, name in enumerate(names)
            }
            keys |= {"soils": names, "definitions": definitions}
        case "speeds":
            keys["speeds_kmh"] = speeds_kmh(count)
        case "workers":
            keys["soils"] = PAPER_SOILS
        case _:
            raise ValueError(axis)
    return study(**keys)


def speeds_kmh(number: int) -> list[float]:
    """Return 150 km/h, or several speeds over the usual range, km/h."""
    return [150.0] if number == 1 else np.linspace(*_SPEEDS_KMH, number).round(3).tolist()


def _trains(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return trains of four vehicles that differ in the distances of their axles."""
    parameters = dict(library.entry("vehicle", "regina").parameters)
    definitions: dict[str, dict[str, Any]] = {}
    for i, name in enumerate(names):
        spacing = parameters["axle_spacing_m"] * (1.0 - 0.02 * i)
        definitions[f"vehicle.{name}"] = {**parameters, "axle_spacing_m": round(spacing, 4)}
        definitions[f"train.{name}"] = {"vehicle": name, "number": 4}
    return definitions


def _figures(axis: str, values: Sequence[float], runs: Sequence[Sequence[RunCost]]) -> Iterator[Figure]:
    """Yield the cost of each value, the slopes, and the ratio with a target, turn by turn."""
    memory = [[run.peak_bytes / 1e6 for run in turns] for turns in runs]
    total = [[run.cpu_s for run in turns] for turns in runs]
    for item, quantity, unit, series in (
        ("total", "wall", "s", [[run.wall_s for run in turns] for turns in runs]),
        ("total", "cpu", "s", total),
        ("tasks", "cpu", "s", [[run.computing_s for run in turns] for turns in runs]),
        ("total", "peak memory of a process", "MB", memory),
    ):
        for value, samples in zip(values, series, strict=True):
            yield Figure(SECTION, item, f"{axis} = {value:g}", quantity, unit, tuple(samples))
        exponent = slope(values, [float(np.median(samples)) for samples in series])
        target = SLOPE if quantity == "cpu" and axis != "workers" else None
        name = f"slope of {quantity}, log-log axes"
        yield Figure(SECTION, item, axis, name, "1", (exponent,), at_most=target)
    if axis in RATIOS:
        ratios = [last / first for first, last in zip(total[0], total[-1], strict=True)]
        name = f"{values[-1]:g} {axis} over {values[0]:g}, cpu"
        if axis == "layers":
            ratios = [ratio ** (1.0 / np.log2(values[-1] / values[0])) for ratio in ratios]
            name = "doubling, cpu"
        yield Figure(SECTION, "total", axis, name, "1", tuple(ratios), at_most=RATIOS[axis])


def _marginal(size: Size, values: Sequence[float], runs: Sequence[Sequence[RunCost]]) -> Iterator[Figure]:
    """Yield what one more speed costs each approach, per 1,000 narrow-band lines of it."""
    train = library.load("train", "grona-taget")
    band = tuple(midbands(*size.bands_hz).tolist())

    def line_count(number: float) -> int:
        return sum(lines(band, train, speed / KMH).frequency.size for speed in speeds_kmh(int(number)))

    added = line_count(values[-1]) - line_count(values[0])
    for approach in runs[0][0].approaches:
        seconds = tuple(
            1e3 * (last.approaches[approach] - first.approaches[approach]) / added
            for first, last in zip(runs[0], runs[-1], strict=True)
        )
        yield Figure(SECTION, approach, "one more speed", "cpu per 1,000 lines", "s", seconds)


def _wavenumbers(size: Size) -> Iterator[Figure]:
    """Yield the time of the tables of one frequency against the number of wavenumbers."""
    ground, track = library.load("soil", SOILS[-1]), library.load("track", TRACK)
    fit = fit_flexibility(ground, 20.0, FIT_TOLERANCE)
    values = size.growth["wavenumbers"]
    item = "strip compliances"
    seconds = []
    for value in values:
        beta = wavenumbers(ground, track, 20.0, int(value))
        call = partial(
            strip_compliances, beta, fit.pole, fit.residue, fit.constant, track.half_width, OFFSETS
        )
        timing = time_call(call, size.samples)
        seconds.append(timing.cpu)
        yield Figure(SECTION, item, f"wavenumbers = {value:g}", "cpu", "s", timing.cpu_s)
    exponent = slope(values, seconds)
    quantity = "slope of cpu, log-log axes"
    yield Figure(SECTION, item, "wavenumbers", quantity, "1", (exponent,), at_most=SLOPE)
