"""Levels are drawn for every receiver, on one range, with hollow markers on extrapolated unevenness."""

import math

import numpy as np
import pytest

from benchmarks.runs.invented import BANDS, RECEIVERS, Study
from queries.database import connect, ingest
from queries.figures import catalogue, level_plots

SEVEN = (8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0)
SOILS = ("horstwalde", "greby clay over moraine, wet", "a soil with a rather long name", "soft")


@pytest.fixture(scope="module")
def four_soils(tmp_path_factory):
    """Return a study of four soils, two with long names, and seven distances."""
    receivers = [*RECEIVERS[:3], *(("ground", offset) for offset in SEVEN)]
    directory = Study(tmp_path_factory.mktemp("run") / "four", receivers).write(soils=SOILS, lines=20)
    ingest(directory)
    return directory


def named(connection, topic):
    return next(drawing for drawing in catalogue.drawings(connection, every=True) if topic in drawing.name)


def test_every_distance_is_drawn(four_soils):
    with connect(four_soils) as connection:
        drawing = named(connection, "ground")
        axes = drawing.draw().axes
    assert len(axes) == len(SOILS) * len(SEVEN)
    titles = [axis.get_title(loc="left") for axis in axes]
    assert [title.split()[1] for title in titles[::4]] == [f"{offset:g}" for offset in SEVEN]
    assert drawing.note == ""


def test_distances_that_are_left_out_are_counted_on_the_figure(tmp_path):
    receivers = [("ground", float(offset)) for offset in range(30)]
    directory = Study(tmp_path / "run", receivers).write(soils=("clay",), lines=20)
    ingest(directory)
    with connect(directory) as connection:
        drawing = named(connection, "ground")
        axes = drawing.draw().axes
    assert len(axes) == 12
    assert drawing.note == "12 of 30 distances are shown."
    assert drawing.note in drawing.caption


@pytest.mark.parametrize("topic", ["ground", "distance", "rail", "force", "narrow-band"])
def test_panels_of_a_figure_have_one_range(four_soils, topic):
    with connect(four_soils) as connection:
        axes = named(connection, topic).draw().axes
    assert len({axis.get_ylim() for axis in axes if axis.get_visible()}) == 1


@pytest.mark.parametrize("topic", ["ground", "distance", "rail", "force", "narrow-band"])
def test_names_of_panels_do_not_overlap(four_soils, topic):
    with connect(four_soils) as connection:
        drawing = named(connection, topic)
        figure = drawing.draw()
    boxes = [
        axis._left_title.get_window_extent(figure.renderer) for axis in figure.axes if axis.get_visible()
    ]
    boxes += [legend.get_window_extent(figure.renderer) for legend in figure.legends]
    for place, box in enumerate(boxes):
        assert box.x1 <= figure.bbox.x1 + 1
        assert not any(box.overlaps(other) for other in boxes[place + 1 :])
    if topic in ("ground", "rail", "narrow-band"):
        assert all(soil in drawing.caption for soil in SOILS)


def test_markers_are_hollow_where_unevenness_is_mostly_extrapolated(results):
    figure = level_plots.rail(results, {"greby": "case-1-150"}, ["full"])
    curve, hollow = figure.axes[0].lines
    shares = np.linspace(0.0, 1.0, BANDS.size)
    np.testing.assert_allclose(hollow.get_xdata(), BANDS[shares > 0.5])
    np.testing.assert_array_equal(curve.get_markevery(), np.flatnonzero(shares <= 0.5))
    assert hollow.get_markerfacecolor() == "white"
    assert hollow.get_markeredgecolor() == curve.get_color()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["full model", "unevenness mostly extrapolated"]


def test_levels_against_distance_leave_out_bands_without_a_level(study):
    directory = study.write(soils=("clay",), lines=10, zero_band=True)
    ingest(directory)
    with connect(directory) as connection:
        figure = level_plots.distance(connection, {"clay": "case-0-150"}, ["full"])
    total = 10 * math.log10(sum(10 ** ((60.0 - 5.0 * 3 - 0.1 * band) / 10) for band in BANDS[1:]))
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), [total, total - 5.0, total - 10.0])
