"""The figures of the paper's section 4, each drawn from rows of the database."""

import math
from collections.abc import Sequence
from typing import Any

import duckdb
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from queries.answers.combination import Combination, columns
from queries.figures.appearance import band_axis, label, legend, level_axis, name_panel, page
from queries.figures.lines import Line, approach_line, numbered_line, plain

_VELOCITY = "velocity level [dB re 1e-9 m/s]"
_FORCE = "force level [dB re 1 N]"
_FREQUENCY = "frequency [Hz]"
_NARROW_RANGE_DB = 70.0
"""What the narrow-band figure shows below its peak."""


class Legend:
    """Collects one handle per label, so that panels share one legend."""

    def __init__(self) -> None:
        self.handles: dict[str, Artist] = {}

    def curve(
        self,
        axis: Axes,
        x: NDArray[Any],
        y: NDArray[Any],
        line: Line,
        markers: bool = True,
        width: float | None = None,
    ) -> None:
        """Draw a line and keep its handle."""
        (handle,) = axis.plot(
            x,
            y,
            color=line.colour,
            linestyle=(0, line.dashes) if line.dashes else "-",
            marker=line.marker if markers else None,
            markersize=line.marker_size,
            linewidth=width or line.width,
            zorder=line.order,
        )
        self.handles.setdefault(line.label, handle)

    def show(self, figure: Figure) -> None:
        """Put the legend above the panels."""
        if self.handles:
            legend(figure, list(self.handles.values()), list(self.handles))


def unevenness(connection: duckdb.DuckDBPyConnection, names: Sequence[str]) -> Figure:
    """Draw the unevenness in one-third octaves of wavelength (Figure 3)."""
    figure, ((axis,),) = page(1, 1, 2.6, named=False)
    shared = Legend()
    ends = []
    for number, name in enumerate(names):
        data = columns(
            connection,
            "SELECT wavelength_m, decibel(mean_square_m2 * 1e12) AS level, extrapolated_share FROM "
            "unevenness_bands "
            "WHERE unevenness = $1 ORDER BY wavelength_m",
            [name],
        )
        line = numbered_line(number, name)
        shared.curve(axis, data["wavelength_m"], data["level"], line)
        outside = np.nan_to_num(data["extrapolated_share"].astype(float)) > 0.5
        if outside.any():
            (handle,) = axis.plot(
                data["wavelength_m"][outside],
                data["level"][outside],
                "o",
                color="white",
                markeredgecolor=line.colour,
                markersize=4.2,
                zorder=3,
            )
            shared.handles.setdefault("mostly outside the form's range of validity", handle)
        ends += [data["wavelength_m"].min(), data["wavelength_m"].max()]
    band_axis(axis, min(ends), max(ends), downwards=True)
    level_axis(axis)
    label(axis, "wavelength, one-third octaves [m]", "unevenness level [dB re 1e-6 m]")
    shared.show(figure)
    return figure


def receptance(
    connection: duckdb.DuckDBPyConnection, soil: str, track: str, speeds: Sequence[float]
) -> Figure:
    """Draw the rail receptance of one soil and track for each speed (Figures 4 and 5)."""
    figure, ((magnitude, phase),) = page(1, 2, 2.5)
    shared = Legend()
    ends = []
    data = columns(
        connection,
        # Trains with other distances between axles have units of their own: one value per frequency.
        "SELECT speed_kmh, frequency_hz, arg_min(receptance_re, unit_id) AS re, "
        "arg_min(receptance_im, unit_id) AS im "
        "FROM receptances, "
        "(SELECT min(band_hz) * 10 ** -0.05 AS lowest, max(band_hz) * 10 ** 0.05 AS highest FROM bands) "
        "WHERE soil = $1 AND track = $2 AND list_contains($3, speed_kmh) AND frequency_hz > 0 "
        "AND coalesce(frequency_hz BETWEEN lowest AND highest, true) "
        "GROUP BY speed_kmh, frequency_hz ORDER BY frequency_hz",
        [soil, track, list(speeds)],
    )
    for number, speed in enumerate(speeds):
        own = data["speed_kmh"] == speed
        frequency, value = data["frequency_hz"][own], (data["re"] + 1j * data["im"])[own]
        line = numbered_line(number, "standing load" if speed == 0 else f"load moving at {speed:g} km/h")
        shared.curve(magnitude, frequency, np.abs(value) * 1e9, line, markers=False)
        shared.curve(phase, frequency, np.unwrap(np.angle(value)), line, markers=False)
        ends += [*frequency[:1], *frequency[-1:]]
    for axis in (magnitude, phase):
        band_axis(axis, min(ends, default=1.0), max(ends, default=100.0))
    magnitude.set_ylim(bottom=0.0)
    label(magnitude, _FREQUENCY, "magnitude of rail receptance [1e-9 m/N]")
    label(phase, _FREQUENCY, "phase [rad]")
    name_panel(magnitude, 0, f"magnitude, {soil}")
    name_panel(phase, 1, f"phase, {soil}")
    shared.show(figure)
    return figure


def force(
    connection: duckdb.DuckDBPyConnection, soil: str, case: Combination, approaches: Sequence[str]
) -> Figure:
    """Draw the wheel-rail force of both axles of the leading bogie (Figures 6 and 7)."""
    figure, (axes,) = page(1, 2, 2.5)
    shared = Legend()
    names = {"axle-1": "leading axle", "axle-2": "trailing axle"}
    curves = _levels(connection, [soil], case, list(names))
    for number, (axis, receiver) in enumerate(zip(axes, names, strict=True)):
        _draw_levels(curves, axis, shared, soil, approaches, receiver)
        name_panel(axis, number, f"{names[receiver]} of the leading bogie, {soil}")
        label(axis, _FREQUENCY, _FORCE if number == 0 else None)
    _same_range(axes)
    shared.show(figure)
    return figure


def rail(
    connection: duckdb.DuckDBPyConnection, soils: Sequence[str], case: Combination, approaches: Sequence[str]
) -> Figure:
    """Draw the rail's velocity in one-third octaves, a panel per soil (Figure 8)."""
    width = min(2, len(soils))
    figure, rows = page(math.ceil(len(soils) / width), width, 2.5)
    panels = [axis for row in rows for axis in row]
    curves = _levels(connection, soils, case, ["rail"])
    shared = Legend()
    for number, soil in enumerate(soils):
        _draw_levels(curves, panels[number], shared, soil, approaches, "rail")
        name_panel(panels[number], number, soil, alone=len(soils) == 1)
        label(panels[number], _FREQUENCY, _VELOCITY if number % width == 0 else None)
    for unused in panels[len(soils) :]:
        unused.set_visible(False)
    _same_range(panels[: len(soils)])
    shared.show(figure)
    return figure


def narrow_band(
    spectra: dict[str, dict[str, tuple[NDArray[Any], NDArray[Any]]]],
    bands: tuple[float, float],
    passing: Sequence[float] = (),
) -> Figure:
    """Draw narrow-band spectra of the rail's velocity, a panel per soil (Figure 9).

    Parameters
    ----------
    spectra
        Per soil and approach the frequencies [Hz] and the one-sided densities [(m/s)²/Hz]; the finest first.
    bands
        Lowest and highest midband, Hz.
    passing
        Frequencies to mark, at which vehicles pass, Hz.
    """
    figure, rows = page(len(spectra), 1, 2.3)
    shared = Legend()
    for number, (soil, by_approach) in enumerate(spectra.items()):
        axis = rows[number][0]
        peak = -math.inf
        for place, (approach, (frequency, density)) in enumerate(by_approach.items()):
            inside = (frequency >= bands[0] * 10**-0.05) & (frequency <= bands[1] * 10**0.05) & (density > 0)
            level = 10.0 * np.log10(density[inside] * 1e18)
            line = approach_line(approach)
            if (
                place == 0 and len(by_approach) > 1
            ):  # in a grey of its own, so that the smoother curves stay readable on it
                line = Line(
                    "#8c8c8c" if line.colour == "#000000" else line.colour, (), line.marker, line.label
                )
            shared.curve(
                axis, frequency[inside], level, line, markers=False, width=0.7 if place == 0 else 1.2
            )
            peak = max(peak, float(level.max(initial=-math.inf)))
        if math.isfinite(peak):
            axis.set_ylim(max(axis.get_ylim()[0], peak - _NARROW_RANGE_DB), peak + 3.0)
        for multiple in passing:
            mark = axis.axvline(multiple, color="#b9a7c9", linewidth=0.8, zorder=1.5)
            shared.handles.setdefault("multiples of speed over vehicle length", mark)
        level_axis(axis)
        band_axis(axis, *bands)
        name_panel(axis, number, soil, alone=len(spectra) == 1)
        label(axis, _FREQUENCY if number == len(spectra) - 1 else None, "density [dB re (1e-9 m/s)²/Hz]")
    shared.show(figure)
    return figure


def ground(
    connection: duckdb.DuckDBPyConnection,
    soils: Sequence[str],
    case: Combination,
    approaches: Sequence[str],
    offsets: Sequence[float],
) -> Figure:
    """Draw the ground's velocity in one-third octaves, a column per soil and a row per offset (Figure 10)."""
    figure, rows = page(len(offsets), len(soils), 1.75)
    curves = _levels(connection, soils, case, ["ground"])
    shared = Legend()
    for row, offset in enumerate(offsets):
        for column, soil in enumerate(soils):
            axis = rows[row][column]
            _draw_levels(curves, axis, shared, soil, approaches, "ground", offset)
            name_panel(
                axis,
                row * len(soils) + column,
                f"{soil}, {offset:g} m from the track's centre",
                len(soils) * len(offsets) == 1,
            )
            label(
                axis,
                _FREQUENCY if row == len(offsets) - 1 else None,
                "level [dB re 1e-9 m/s]" if column == 0 else None,
            )
        _same_range(rows[row])
    shared.show(figure)
    return figure


_Curves = dict[tuple[str, str, str, float | None], tuple[NDArray[Any], NDArray[Any]]]
"""Bands [Hz] and levels [dB] by soil, approach, receiver and offset [m]."""


def _levels(
    connection: duckdb.DuckDBPyConnection, soils: Sequence[str], case: Combination, receivers: Sequence[str]
) -> _Curves:
    """Return the dynamic levels of receivers on several soils, by one query: each takes milliseconds."""
    rows = connection.execute(
        "SELECT soil, approach, receiver, offset_m, list(band_hz ORDER BY band_hz), "
        "list(level_db ORDER BY band_hz) FROM levels WHERE list_contains($1, soil) AND track = $2 "
        "AND train = $3 AND unevenness = $4 AND speed_kmh = $5 AND list_contains($6, receiver) "
        "AND contribution = 'dynamic' AND averaging = 'line' GROUP BY ALL",
        [list(soils), case.track, case.train, case.unevenness, case.speed_kmh, list(receivers)],
    ).fetchall()
    return {
        (soil, approach, receiver, offset): (np.array(band), np.array(level, dtype=float))
        for soil, approach, receiver, offset, band, level in rows
    }


def _draw_levels(
    curves: _Curves,
    axis: Axes,
    shared: Legend,
    soil: str,
    approaches: Sequence[str],
    receiver: str,
    offset: float | None = None,
) -> None:
    """Draw the levels of one receiver, a line per approach that has results."""
    ends: list[float] = []
    for approach in approaches:
        if (soil, approach, receiver, offset) in curves:
            band, level = curves[soil, approach, receiver, offset]
            shared.curve(axis, band, level, approach_line(approach))
            ends += [band[0], band[-1]]
    level_axis(axis)
    if ends:
        band_axis(axis, min(ends), max(ends))
    else:
        axis.text(
            0.5,
            0.5,
            f"no results for {plain(receiver)}",
            ha="center",
            va="center",
            transform=axis.transAxes,
            fontsize=8,
        )


def _same_range(axes: Sequence[Axes]) -> None:
    """Give panels that are read against each other one range of levels."""
    drawn = [axis.get_ylim() for axis in axes if axis.lines]
    for axis in axes:
        if drawn:
            axis.set_ylim(min(low for low, _ in drawn), max(high for _, high in drawn))
