"""Section 2: transfer functions of one frequency, against the textbook grid, quadrature, and the limit."""

from collections.abc import Callable, Generator, Iterator
from functools import partial

import numpy as np
import psutil

from benchmarks.figures import Figure, time_call
from benchmarks.limit.operations import count_operations
from benchmarks.limit.rates import Rates
from benchmarks.peers import adaptive_quadrature, fourier_grid, stiffness_matrices
from benchmarks.peers.fourier_grid import ERROR, OFFSETS, Flexibility, Grid
from benchmarks.sizes import Size
from railvib import library
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import threads
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.soil._kernels.strip import strip_compliances
from railvib.soil.rational_fit import RationalFit, fit_flexibility
from railvib.soil.strip import strip_compliance
from railvib.transfer.nodes import TOP, Nodes, largest_wavenumber
from railvib.transfer.track_response import track_response

SECTION = "transfer"
SOILS = ("horstwalde", "greby")
TRACK = "ballasted-paper"
WAVENUMBERS = 700
FIT_TOLERANCE = 1e-10
"""A millionth of the default tolerance of a study, as for the tables."""
TABLE_ERROR = 1e-4
SPEEDS = 20
FACTOR_OF_LIMIT = 4.0
TABLES_S = 5e-3
LEAST, MEDIAN, MEDIAN_OF_SWEEP = 50.0, 300.0, 2000.0
"""Speed-up over the textbook way: in every band, in the median, and in the median of a sweep."""
_COUNTED = 16
"""Wavenumbers at which operations are counted."""


def measure(size: Size, rates: Rates) -> Iterator[Figure]:
    """Yield times of each soil and one-third octave, and the ratios over all of them."""
    track = library.load("track", TRACK)
    speedups: dict[str, list[float]] = {}
    for soil in SOILS:
        ground = library.load("soil", soil)
        for band in size.bands:
            frequency = float(10.0 ** (band / 10.0))
            case = f"{soil} {frequency:.3g} Hz"
            tables = _Tables(ground, track, frequency)
            cpu = yield from tables.measure(case, size, rates)
            yield from _quadrature(tables, case, size, cpu)
            textbook = yield from _textbook(tables, case, size)
            for name, seconds in textbook.items():
                ratio = seconds / cpu
                speedups.setdefault(name, []).append(ratio)
                yield Figure(SECTION, name, case, "railvib is faster by", "1", (ratio,), at_least=LEAST)
    for name, ratios in speedups.items():
        median = float(np.median(ratios))
        sweep = f"{SPEEDS} speeds, railvib is faster by, median"
        for quantity, value, target in (
            ("railvib is faster by, least", min(ratios), LEAST),
            ("railvib is faster by, median", median, MEDIAN),
            (sweep, SPEEDS * median, MEDIAN_OF_SWEEP),
        ):
            yield Figure(SECTION, name, "all bands", quantity, "1", (value,), at_least=target)


class _Tables:
    """Transfer functions of one frequency as railvib computes them."""

    def __init__(self, ground: Ground, track: Track, frequency: float) -> None:
        self.ground, self.track, self.frequency = ground, track, frequency
        self.omega = 2.0 * np.pi * frequency
        step = float(blocks.frequency(0, 1) / blocks.frequency(0, 0))
        self.start = fit_flexibility(ground, frequency / step, FIT_TOLERANCE).start
        self.fit = self.fit_from_neighbour()
        self.beta = wavenumbers(ground, track, frequency)

    def fit_from_neighbour(self) -> RationalFit:
        """Return the fit, started from that of the neighbouring frequency as for the tables."""
        return fit_flexibility(self.ground, self.frequency, FIT_TOLERANCE, self.start)

    def compliance(self, fit: RationalFit) -> np.ndarray:
        """Return C(β, y), (offsets, wavenumbers)."""
        return strip_compliance(fit, self.beta, self.track.half_width, OFFSETS)

    def responses(self, compliance: np.ndarray) -> np.ndarray:
        """Return H̃_R and H̃_G, (1 + offsets, wavenumbers)."""
        rail, force = track_response(self.track, self.beta, self.omega, compliance[0])
        return np.concatenate([rail[None], force * compliance])

    def measure(self, case: str, size: Size, rates: Rates) -> Generator[Figure, None, float]:
        """Yield times by stage and the ratio to the limit; return the CPU seconds of all stages."""
        compliance = self.compliance(self.fit)
        cold = partial(fit_flexibility, self.ground, self.frequency, FIT_TOLERANCE)
        strips = time_call(lambda: self.compliance(self.fit), size.samples)
        yield from time_call(cold, size.samples).figures(SECTION, "fit, cold", case)
        warm = time_call(self.fit_from_neighbour, size.samples)
        yield from warm.figures(SECTION, "fit, from its neighbour", case)
        yield from strips.figures(SECTION, "strip compliances", case)
        yield from time_call(lambda: self.responses(compliance), size.samples).figures(SECTION, "track", case)
        whole = time_call(lambda: self.responses(self.compliance(self.fit_from_neighbour())), size.samples)
        yield from whole.figures(SECTION, "fit and tables", case, at_most=TABLES_S)
        yield Figure(SECTION, "fit and tables", case, "poles", "1", (float(self.fit.pole.size),))
        beta = self.beta[:: self.beta.size // _COUNTED][:_COUNTED]
        fit = self.fit
        arguments = (beta, fit.pole, fit.residue, fit.constant, self.track.half_width, OFFSETS)
        _, count = count_operations(strip_compliances, arguments, STRETCH=1)
        all_values = self.beta.size / beta.size
        item, quantity = "strip compliances, time over limit", "all at the multiply-add rate"
        ratio = strips.cpu / (all_values * count.seconds(rates))
        yield Figure(SECTION, item, case, quantity, "1", (ratio,), at_most=FACTOR_OF_LIMIT)
        ratio = strips.cpu / (all_values * count.seconds_by_kind(rates))
        yield Figure(SECTION, item, case, "divisions and roots at their rates", "1", (ratio,))
        return whole.cpu


def wavenumbers(ground: Ground, track: Track, frequency: float, number: int = WAVENUMBERS) -> np.ndarray:
    """Return wavenumbers as in tables: half below the slowest wave's, half above."""
    top = TOP / ground.slowest_speed
    largest = max(largest_wavenumber(track), 8.0 * np.pi * frequency * top)
    nodes = Nodes(top, largest, np.linspace(0.0, 2.0, number // 12 + 2))
    return np.ascontiguousarray(nodes.wavenumber(np.array([frequency]))[0, :number])


def _quadrature(tables: _Tables, case: str, size: Size, cpu: float) -> Iterator[Figure]:
    """Yield the time of adaptive quadrature, and the error of the tables against its tight result."""
    exact = tables.compliance(tables.fit).T

    def quadrature(tolerance: float) -> np.ndarray:
        return adaptive_quadrature.compliances(
            tables.ground, tables.track.half_width, tables.beta, OFFSETS, tables.frequency, tolerance
        )

    def error(tolerance: float) -> float:
        return _error(quadrature(tolerance), exact)

    name = "error against quadrature"
    yield Figure(SECTION, "strip compliances", case, name, "1", (error(1e-7),), at_most=TABLE_ERROR)
    loosest = next((tolerance for tolerance in (1.0, 0.1, 1e-2, 1e-3) if error(tolerance) <= ERROR), 1e-4)
    timing = time_call(lambda: quadrature(loosest), min(size.samples, 3))
    yield from timing.figures(SECTION, "adaptive quadrature", case)
    yield Figure(SECTION, "adaptive quadrature", case, "railvib is faster by", "1", (timing.cpu / cpu,))


def _textbook(tables: _Tables, case: str, size: Size) -> Generator[Figure, None, dict[str, float]]:
    """Yield size, error and time of the textbook table; return CPU seconds by the flexibility used."""
    grid = fourier_grid.coarsest(tables.ground, tables.track, tables.frequency, tables.fit)
    item = "textbook grid"
    yield Figure(SECTION, item, case, "spacing", "rad/m", (grid.across,))
    yield Figure(SECTION, item, case, "rows", "1", (float(grid.rows),))
    yield Figure(SECTION, item, case, "columns", "1", (float(grid.columns),))
    yield Figure(SECTION, item, case, "table", "GB", (grid.table_bytes / 1e9,))
    share = grid.table_bytes / psutil.virtual_memory().total
    yield Figure(SECTION, item, case, "table over this machine's memory", "1", (share,))
    seconds: dict[str, float] = {}
    flexibilities: dict[str, Flexibility] = {
        "textbook, Q33 of railvib": fourier_grid.kernel(tables.ground, tables.omega),
        "textbook, Q33 in NumPy": _in_numpy(tables),
    }
    for name, flexibility in flexibilities.items():
        way, rows, values, times = _rows(flexibility, tables, grid, size)
        error = _error(values, fourier_grid.closed_form(tables.fit, tables.track.half_width, rows))
        yield Figure(SECTION, name, case, "error", "1", (error,), at_most=ERROR)
        under = np.ascontiguousarray(values[:, 0])
        track = time_call(partial(track_response, tables.track, rows, tables.omega, under), 1).cpu
        whole = tuple(time_s + track * grid.rows / rows.size for time_s in times)
        yield Figure(SECTION, name, case, "rows measured", "1", (float(min(rows.size, grid.rows)),))
        yield Figure(SECTION, name, case, "cpu, all rows", "s", whole)
        seconds[name] = float(np.median(whole))
        if float(np.median(times)) <= size.textbook_s:
            every = time_call(partial(_all_rows, way, grid), 1, 0.0).cpu / float(np.median(times))
            yield Figure(SECTION, name, case, "all rows measured, over extrapolated", "1", (every,))
    return seconds


Way = Callable[[np.ndarray], np.ndarray]
"""Returns C(β, y) at some rows of the grid."""


def _error(values: np.ndarray, exact: np.ndarray) -> float:
    """Return the largest error of C(β, y), both (β, offsets), over |C(β, 0)|."""
    return float((np.abs(values - exact) / np.abs(exact[:, :1])).max())


def _all_rows(way: Way, grid: Grid) -> None:
    """Compute all of a table, block by block."""
    together = min(grid.rows_together, grid.rows)
    for start in range(0, grid.rows, together):
        way(np.arange(start, min(start + together, grid.rows)) * grid.along)


def _in_numpy(tables: _Tables) -> Flexibility:
    """Return the flexibility by matrices in NumPy; at ρ = 0, where they fail, that of a tiny wavenumber."""

    def flexibility(wavenumber: np.ndarray) -> np.ndarray:
        return stiffness_matrices.by_elimination(tables.ground, np.maximum(wavenumber, 1e-6), tables.omega)

    return flexibility


def _rows(
    flexibility: Flexibility, tables: _Tables, grid: Grid, size: Size
) -> tuple[Way, np.ndarray, np.ndarray, tuple[float, ...]]:
    """Compute blocks of rows spread over the grid; return the way, β, values, seconds of all rows by block.

    Rows cost the same wherever they lie, so blocks are samples, and the time of all rows is that of a block
    times their number: most tables take too long, and the largest do not fit in memory. Transforms and sums
    are both tried, and the quicker is taken.
    """
    b = tables.track.half_width
    together = min(grid.rows_together, grid.rows)
    cosines = fourier_grid.cosines(grid)
    ways: list[Way] = [
        lambda beta: fourier_grid.by_transform(flexibility, b, beta, grid),
        lambda beta: fourier_grid.by_sums(flexibility, b, beta, grid, cosines),
    ]
    with threads.single():
        first = np.arange(together) * grid.along
        way = min(ways, key=lambda way: time_call(lambda: way(first), 1).cpu)
        starts = np.linspace(0, max(grid.rows - together, 0), size.samples).astype(int)
        rows, values, times = [], [], []
        for start in starts:
            beta = (start + np.arange(together)) * grid.along
            rows.append(beta)
            values.append(way(beta))
            seconds = time_call(partial(way, beta), 1, size.textbook_s / size.samples).cpu
            times.append(seconds * grid.rows / together)
    return way, np.concatenate(rows), np.concatenate(values), tuple(times)
