"""Unevenness of the rails and receptance of the rail (Figures 3 to 5)."""

from collections.abc import Sequence

import duckdb
import numpy as np
from matplotlib.figure import Figure

from queries.database import fetch_columns
from queries.figures.appearance import Legend, band_axis, label, level_axis, name_panel, page
from queries.figures.lines import numbered_line
from queries.statements import statements

_SQL = statements("queries.figures", "plots")
_FREQUENCY = "frequency [Hz]"


def unevenness(connection: duckdb.DuckDBPyConnection, names: Sequence[str]) -> Figure:
    """Draw the unevenness in one-third octaves of wavelength."""
    figure, ((axis,),) = page(1, 1, 2.6, named=False)
    legend = Legend()
    ends = []
    for number, name in enumerate(names):
        data = fetch_columns(connection, _SQL["unevenness"], [name])
        hollow = np.nan_to_num(data["extrapolated_share"].astype(float)) > 0.5
        legend.curve(axis, data["wavelength_m"], data["level"], numbered_line(number, name), hollow=hollow)
        ends += [data["wavelength_m"].min(), data["wavelength_m"].max()]
    band_axis(axis, min(ends), max(ends), downwards=True)
    level_axis(axis)
    label(axis, "wavelength, one-third octaves [m]", "unevenness level [dB re 1e-6 m]")
    legend.show(figure)
    return figure


def receptance(
    connection: duckdb.DuckDBPyConnection, soil: str, track: str, speeds: Sequence[float]
) -> Figure:
    """Draw the rail receptance of one soil and track for each speed."""
    figure, ((magnitude, phase),) = page(1, 2, 2.5)
    legend = Legend()
    ends: list[float] = []
    data = fetch_columns(connection, _SQL["receptance"], [soil, track, list(speeds)])
    for number, speed in enumerate(speeds):
        of_speed = data["speed_kmh"] == speed
        frequency, value = data["frequency_hz"][of_speed], (data["re"] + 1j * data["im"])[of_speed]
        line = numbered_line(number, "standing load" if speed == 0 else f"load moving at {speed:g} km/h")
        legend.curve(magnitude, frequency, np.abs(value) * 1e9, line, markers=False)
        legend.curve(phase, frequency, np.unwrap(np.angle(value)), line, markers=False)
        ends += [*frequency[:1], *frequency[-1:]]
    for axis in (magnitude, phase):
        band_axis(axis, min(ends, default=1.0), max(ends, default=100.0))
    magnitude.set_ylim(bottom=0.0)
    label(magnitude, _FREQUENCY, "magnitude of rail receptance [1e-9 m/N]")
    label(phase, _FREQUENCY, "phase [rad]")
    name_panel(magnitude, 0, f"magnitude, {soil}")
    name_panel(phase, 1, f"phase, {soil}")
    legend.show(figure)
    return figure
