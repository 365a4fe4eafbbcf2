"""Narrow-band spectra are marked where vehicles of each length pass."""

import numpy as np
import pytest

from benchmarks.runs.invented import VEHICLE
from queries.database import connect, ingest
from queries.figures import catalogue
from queries.report.data import data

SPEED = 150 / 3.6
LOCOMOTIVE, WAGON = {**VEHICLE, "length_m": 18.9}, {**VEHICLE, "length_m": 14.04}


@pytest.fixture
def mixed(study):
    """Return the results of a train of a locomotive and twelve shorter wagons."""
    directory = study.write(soils=("clay",), vehicles=[LOCOMOTIVE] + [WAGON] * 12)
    ingest(directory)
    with connect(directory) as connection:
        yield connection


def narrow_band(connection):
    return next(drawing for drawing in catalogue.drawings(connection) if "narrow-band" in drawing.name)


def test_each_length_of_vehicles_has_its_multiples(mixed):
    figure = narrow_band(mixed).draw()
    marks = {}
    for line in figure.axes[0].lines:
        if len(line.get_xdata()) == 2:
            marks.setdefault(line.get_color(), []).append(line.get_xdata()[0])
    wagons, locomotive = marks.values()
    np.testing.assert_allclose(wagons, np.arange(1, 9) * SPEED / 14.04)
    np.testing.assert_allclose(locomotive, np.arange(1, 9) * SPEED / 18.9)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[2:] == ["multiples of v / 14.04 m, 12 vehicles", "multiples of v / 18.9 m, 1 vehicle"]


def test_the_page_has_each_length_of_vehicles(mixed):
    assert data(mixed)["trains"] == {
        "grona-taget": [
            {"length": 14.04, "axles": 2.7, "count": 12},
            {"length": 18.9, "axles": 2.7, "count": 1},
        ]
    }


def test_lengths_that_are_left_out_are_counted_on_the_figure(study):
    vehicles = [{**VEHICLE, "length_m": 20.0 + number} for number in range(5)]
    directory = study.write(soils=("clay",), vehicles=vehicles)
    ingest(directory)
    with connect(directory) as connection:
        drawing = narrow_band(connection)
    assert drawing.note == "2 of 3 approaches are shown. 3 of 5 lengths of vehicles are shown."
