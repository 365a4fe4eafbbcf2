"""Section 2: transfer functions of one frequency, against the textbook grid, quadrature, and the limit."""

from collections.abc import Callable, Generator, Iterator
from functools import partial

import numpy as np
import psutil

from benchmarks import adaptive_quadrature, fourier_grid, stiffness_matrices
from benchmarks.arithmetic import Rates
from benchmarks.figures import Figure, timed
from benchmarks.fourier_grid import ERROR, OFFSETS, Flexibility, Grid
from benchmarks.operations import counted
from benchmarks.sizes import Size
from railvib import library
from railvib.numerics import frequency_blocks as blocks
from railvib.numerics import threads
from railvib.parameters.ground import Ground
from railvib.parameters.track import Track
from railvib.soil.rational_fit import RationalFit, fit_flexibility
from railvib.soil.strip import strip_compliances
from railvib.transfer.nodes import TOP, Nodes
from railvib.transfer.tabulate import largest_wavenumber
from railvib.transfer.track_response import track_response

SECTION = "transfer"
SOILS = ("horstwalde", "greby")
TRACK = "ballasted-paper"
WAVENUMBERS = 700
FIT_TOLERANCE = 1e-10
"""A millionth of the default tolerance of a study, as the tables ask for it."""
OWN_ERROR = 1e-4
SPEEDS = 20
FACTOR_OF_LIMIT = 4.0
TABLES_S = 5e-3
LEAST, MEDIAN, MEDIAN_OF_SWEEP = 50.0, 300.0, 2000.0
"""How many times faster than the textbook way: in every band, in the median, and in that of a sweep."""
_COUNTED = 16


def measure(size: Size, rates: Rates) -> Iterator[Figure]:
    """Yield times of each soil and one-third octave, and the ratios over all of them."""
    track = library.load("track", TRACK)
    ratios: dict[str, list[float]] = {}
    for soil in SOILS:
        ground = library.load("soil", soil)
        for band in size.bands:
            frequency = float(10.0 ** (band / 10.0))
            case = f"{soil} {frequency:.3g} Hz"
            own = _Own(ground, track, frequency)
            cpu = yield from own.measure(case, size, rates)
            yield from _quadrature(own, case, size, cpu)
            textbook = yield from _textbook(own, case, size)
            for name, spent in textbook.items():
                ratios.setdefault(name, []).append(spent / cpu)
                yield Figure(SECTION, name, case, "railvib is faster by", "1", (spent / cpu,), at_least=LEAST)
    for name, found in ratios.items():
        median = float(np.median(found))
        sweep = f"{SPEEDS} speeds, railvib is faster by, median"
        for quantity, value, aim in (
            ("railvib is faster by, least", min(found), LEAST),
            ("railvib is faster by, median", median, MEDIAN),
            (sweep, SPEEDS * median, MEDIAN_OF_SWEEP),
        ):
            yield Figure(SECTION, name, "all bands", quantity, "1", (value,), at_least=aim)


class _Own:
    """The way of railvib at one frequency."""

    def __init__(self, ground: Ground, track: Track, frequency: float) -> None:
        self.ground, self.track, self.frequency = ground, track, frequency
        self.omega = 2.0 * np.pi * frequency
        step = float(blocks.frequency(0, 1) / blocks.frequency(0, 0))
        self.start = fit_flexibility(ground, frequency / step, FIT_TOLERANCE).start
        self.fit = self.fitted()
        self.beta = wavenumbers(ground, track, frequency)

    def fitted(self) -> RationalFit:
        """Return the fit, from the neighbouring frequency's, as tables make it."""
        return fit_flexibility(self.ground, self.frequency, FIT_TOLERANCE, self.start)

    def compliance(self, fit: RationalFit) -> np.ndarray:
        """Return C(β, y), (offsets, wavenumbers)."""
        real, imag = strip_compliances(
            self.beta, fit.pole, fit.residue, fit.constant, self.track.half_width, OFFSETS
        )
        return np.asarray(real + 1j * imag)

    def loaded(self, compliance: np.ndarray) -> np.ndarray:
        """Return H̃_R and H̃_G, (1 + offsets, wavenumbers)."""
        rail, force = track_response(self.track, self.beta, self.omega, compliance[0])
        return np.concatenate([rail[None], force * compliance])

    def measure(self, case: str, size: Size, rates: Rates) -> Generator[Figure, None, float]:
        """Yield times stage by stage and the ratio to the limit; return the CPU seconds of all stages."""
        compliance = self.compliance(self.fit)
        cold = partial(fit_flexibility, self.ground, self.frequency, FIT_TOLERANCE)
        fit = timed(self.fitted, size.samples)
        strips = timed(lambda: self.compliance(self.fit), size.samples)
        yield from timed(cold, size.samples).figures(SECTION, "fit, cold", case)
        yield from fit.figures(SECTION, "fit, from its neighbour", case)
        yield from strips.figures(SECTION, "strip compliances", case)
        yield from timed(lambda: self.loaded(compliance), size.samples).figures(SECTION, "track", case)
        whole = timed(lambda: self.loaded(self.compliance(self.fitted())), size.samples)
        yield from whole.figures(SECTION, "fit and tables", case, at_most=TABLES_S)
        yield Figure(SECTION, "fit and tables", case, "poles", "1", (float(self.fit.pole.size),))
        _, count = counted(
            strip_compliances,
            (
                self.beta[:: self.beta.size // _COUNTED][:_COUNTED],
                self.fit.pole,
                self.fit.residue,
                self.fit.constant,
                self.track.half_width,
                OFFSETS,
            ),
            STRETCH=1,
        )
        share = self.beta.size / _COUNTED
        name = "strip compliances, time over limit"
        limit, by_kind = share * count.seconds(rates), share * count.seconds_by_kind(rates)
        yield Figure(
            SECTION,
            name,
            case,
            "all at the multiply-add rate",
            "1",
            (strips.cpu / limit,),
            at_most=FACTOR_OF_LIMIT,
        )
        yield Figure(SECTION, name, case, "divisions and roots at their rates", "1", (strips.cpu / by_kind,))
        return whole.cpu


def wavenumbers(ground: Ground, track: Track, frequency: float, number: int = WAVENUMBERS) -> np.ndarray:
    """Return wavenumbers as tables have them: half below the slowest wave's, half from there on."""
    top = TOP / ground.slowest_speed
    largest = max(largest_wavenumber(track), 8.0 * np.pi * frequency * top)
    nodes = Nodes(top, largest, np.linspace(0.0, 2.0, number // 12 + 2))
    return np.ascontiguousarray(nodes.wavenumber(np.array([frequency]))[0, :number])


def _quadrature(own: _Own, case: str, size: Size, cpu: float) -> Iterator[Figure]:
    """Yield the time of adaptive quadrature, and our error against its tight result."""
    exact = own.compliance(own.fit).T
    under = np.abs(exact[:, :1])

    def way(tolerance: float) -> np.ndarray:
        return adaptive_quadrature.compliances(
            own.ground, own.track.half_width, own.beta, OFFSETS, own.frequency, tolerance
        )

    judged = float((np.abs(way(1e-7) - exact) / under).max())
    yield Figure(
        SECTION, "strip compliances", case, "error against quadrature", "1", (judged,), at_most=OWN_ERROR
    )
    loosest = next(
        each
        for each in (1.0, 0.1, 1e-2, 1e-3, 1e-4)
        if (np.abs(way(each) - exact) / under).max() <= ERROR or each == 1e-4
    )
    spent = timed(lambda: way(loosest), min(size.samples, 3))
    yield from spent.figures(SECTION, "adaptive quadrature", case)
    yield Figure(SECTION, "adaptive quadrature", case, "railvib is faster by", "1", (spent.cpu / cpu,))


def _textbook(own: _Own, case: str, size: Size) -> Generator[Figure, None, dict[str, float]]:
    """Yield size, error and time of the textbook table; return CPU seconds by the flexibility used."""
    grid = fourier_grid.coarsest(own.ground, own.track, own.frequency, own.fit)
    item = "textbook grid"
    yield Figure(SECTION, item, case, "spacing", "rad/m", (grid.across,))
    yield Figure(SECTION, item, case, "rows", "1", (float(grid.rows),))
    yield Figure(SECTION, item, case, "columns", "1", (float(grid.columns),))
    yield Figure(SECTION, item, case, "table", "GB", (grid.table_bytes / 1e9,))
    over = grid.table_bytes / psutil.virtual_memory().total
    yield Figure(SECTION, item, case, "table over this machine's memory", "1", (over,))
    spent: dict[str, float] = {}
    ways: dict[str, Flexibility] = {
        "textbook, Q33 of railvib": fourier_grid.kernel(own.ground, own.omega),
        "textbook, Q33 in NumPy": _in_numpy(own),
    }
    for name, flexibility in ways.items():
        quick, rows, found, times = _rows(flexibility, own, grid, size)
        exact = fourier_grid.closed_form(own.fit, own.track.half_width, rows)
        error = float((np.abs(found - exact) / np.abs(exact[:, :1])).max())
        yield Figure(SECTION, name, case, "error", "1", (error,), at_most=ERROR)
        track = timed(
            partial(track_response, own.track, rows, own.omega, np.ascontiguousarray(found[:, 0])), 1
        ).cpu
        whole = tuple(each + track * grid.rows / rows.size for each in times)
        yield Figure(SECTION, name, case, "rows measured", "1", (float(min(rows.size, grid.rows)),))
        yield Figure(SECTION, name, case, "cpu, all rows", "s", whole)
        spent[name] = float(np.median(whole))
        if float(np.median(times)) <= size.textbook_s:
            every = timed(partial(_whole, quick, grid), 1, 0.0).cpu / float(np.median(times))
            yield Figure(SECTION, name, case, "all rows measured, over extrapolated", "1", (every,))
    return spent


Way = Callable[[np.ndarray], np.ndarray]
"""Returns C(β, y) at some rows of the grid."""


def _whole(way: Way, grid: Grid) -> None:
    """Compute all of a table."""
    together = min(grid.rows_together, grid.rows)
    for start in range(0, grid.rows, together):
        way(np.arange(start, min(start + together, grid.rows)) * grid.along)


def _in_numpy(own: _Own) -> Flexibility:
    """Return the flexibility by matrices in NumPy; at no wavenumber at all that next to nothing."""

    def flexibility(wavenumber: np.ndarray) -> np.ndarray:
        return stiffness_matrices.by_elimination(own.ground, np.maximum(wavenumber, 1e-6), own.omega)

    return flexibility


def _rows(
    flexibility: Flexibility, own: _Own, grid: Grid, size: Size
) -> tuple[Way, np.ndarray, np.ndarray, tuple[float, ...]]:
    """Compute blocks of rows spread over the grid; return the way, β, values, seconds of all rows by block.

    Rows cost the same wherever they lie, so blocks are samples, and the time of all rows is that of a block
    times their number: most tables take too long, and the largest do not fit in memory. Transforms and sums
    are both tried, and the quicker is taken.
    """
    b = own.track.half_width
    together = min(grid.rows_together, grid.rows)
    cosines = fourier_grid.cosines(grid)
    ways: list[Way] = [
        lambda beta: fourier_grid.by_transform(flexibility, b, beta, grid),
        lambda beta: fourier_grid.by_sums(flexibility, b, beta, grid, cosines),
    ]
    with threads.single():
        first = np.arange(together) * grid.along
        quick = min(ways, key=lambda way: timed(lambda: way(first), 1).cpu)
        blocks_at = np.linspace(0, max(grid.rows - together, 0), size.samples).astype(int)
        rows, found, times = [], [], []
        for start in blocks_at:
            beta = (start + np.arange(together)) * grid.along
            rows.append(beta)
            found.append(quick(beta))
            spent = timed(partial(quick, beta), 1, size.textbook_s / size.samples).cpu
            times.append(spent * grid.rows / together)
    return quick, np.concatenate(rows), np.concatenate(found), tuple(times)
