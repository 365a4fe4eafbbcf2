"""Figures: which there are, that they show what the database holds, and that names do no harm."""

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.runs.invented import BANDS
from queries import cli
from queries.database import DATABASE, connect, ingest
from queries.figures import FigureProcesses, appearance, catalogue, error_plots, level_plots, track_plots
from queries.figures.drawing import sample
from queries.figures.write import write

CASES = {"horstwalde": "case-0-150", "greby": "case-1-150"}
"""Ids of the cases of the plain study by soil."""
PAPER = [
    "figure-03-unevenness",
    "figure-04-receptance-horstwalde",
    "figure-05-receptance-greby",
    "figure-06-force-horstwalde",
    "figure-07-force-greby",
    "figure-08-rail",
    "figure-09-narrow-band",
    "figure-10-ground",
]


def names(directory):
    with connect(directory) as connection:
        return [drawing.name for drawing in catalogue.drawings(connection)]


def draw(directory, kind="png"):
    with connect(directory) as connection:
        return FigureProcesses(0).start(connection, directory / DATABASE, directory / "figures", kind)()


def lines(axis):
    """Return the curves of a panel by colour."""
    return {line.get_color(): line.get_ydata() for line in axis.lines}


def test_the_paper_has_its_figures(paper):
    assert names(paper) == PAPER


def test_figures_are_files_that_are_not_blank(study):
    directory = study.write()
    ingest(directory)
    published = draw(directory)
    with connect(directory) as connection:
        assert catalogue.are_drawn(connection, directory / "figures")
    assert published == [directory / "figures" / f"{name}.png" for name in PAPER]
    for path in published:
        picture = matplotlib.image.imread(path)
        assert picture.shape[1] > 1000
        assert 0.01 < np.mean(picture[..., :3].min(axis=2) < 0.8) < 0.5


def test_figures_of_an_earlier_state_go(study):
    directory = study.write(lost=("moving-roughness", "moving-roughness-uncorrelated", "full"))
    ingest(directory)
    (directory / "figures").mkdir()
    for kind in ("png", "txt"):
        (directory / "figures" / f"figure-04-receptance-old.{kind}").touch()
    (directory / "figures" / "mine.png").touch()
    draw(directory)
    left = {path.name for path in (directory / "figures").iterdir()}
    assert left == {"mine.png", *(f"{name}.{kind}" for name in PAPER[:3] for kind in ("png", "txt"))}


def test_axes_with_several_values_are_in_the_name(study):
    directory = study.write(speeds=(100.0, 150.5), lines=10)
    ingest(directory)
    found = names(directory)
    assert "figure-06-force-horstwalde-100-kmh" in found
    assert "figure-10-ground-150-5-kmh" in found
    assert len(found) == len(set(found))


def test_soils_that_look_alike_in_a_file_name_stay_apart(study):
    directory = study.write(soils=("a b", "a/b", "../a;b"), lines=10)
    ingest(directory)
    found = [name for name in names(directory) if "receptance" in name]
    assert found == ["figure-04-receptance-a-b", "figure-05-receptance-a-b", "figure-05-receptance-a-b-2"]


def test_long_names_of_soils_make_names_of_files(study):
    directory = study.write(soils=("s" * 250, "s" * 251), lines=10)
    ingest(directory)
    assert all(len(name) < 220 for name in names(directory))
    assert len(draw(directory)) == len(names(directory))


def test_many_cases_are_sampled_and_it_is_said(study):
    directory = study.write(soils=tuple(f"soil {n}" for n in range(7)), speeds=(100.0, 150.0), lines=10)
    ingest(directory)
    with connect(directory) as connection:
        found = catalogue.drawings(connection)
    assert sum("force" in drawing.name for drawing in found) == 4 * 2
    note = "A sample: 4 of 7 soils and 2 of 2 combinations of track, train, unevenness and speed."
    sampled = [drawing for drawing in found if "unevenness" not in drawing.name]
    assert len(sampled) == len(found) - 1
    assert all(drawing.note.startswith(note) and note in drawing.caption for drawing in sampled)


def test_a_sample_keeps_both_ends():
    assert sample(range(10), 4) == [0, 3, 6, 9]
    assert sample("ab", 4) == ["a", "b"]


def test_the_rail_figure_shows_the_levels(results):
    figure = level_plots.rail(results, CASES, ["moving-roughness", "full"])
    for soil, axis in enumerate(figure.axes):
        expected = 50.0 + 10.0 * soil - 0.1 * BANDS
        np.testing.assert_allclose(lines(axis)["#000000"], expected)
        np.testing.assert_allclose(lines(axis)["#0072B2"], expected + 1.0)


def test_the_ground_figure_has_a_row_per_offset_and_a_column_per_soil(results):
    figure = level_plots.ground(results, CASES, ["full"], [0.0, 8.0, 32.0])
    for place, axis in enumerate(figure.axes):
        expected = 60.0 + 10.0 * (place % 2) - 5.0 * (3 + place // 2) - 0.1 * BANDS
        np.testing.assert_allclose(lines(axis)["#000000"], expected)


def test_the_force_figure_shows_the_leading_axle_first(results):
    figure = level_plots.force(results, "horstwalde", "case-0-150", ["full"])
    np.testing.assert_allclose(lines(figure.axes[0])["#000000"], 60.0 - 0.1 * BANDS)
    np.testing.assert_allclose(lines(figure.axes[1])["#000000"], 55.0 - 0.1 * BANDS)


def test_the_receptance_figure_shows_magnitude_and_phase(results):
    figure = track_plots.receptance(results, "greby", "ballasted-paper", [0.0, 150.0])
    magnitude, phase = (axis.lines for axis in figure.axes)
    frequency = magnitude[0].get_xdata()
    expected = 5.0 / (1.0 - (frequency / 11.0) ** 2 + 0.4j)
    np.testing.assert_allclose(magnitude[0].get_ydata(), np.abs(expected))
    np.testing.assert_allclose(phase[0].get_ydata(), np.unwrap(np.angle(expected)))
    assert frequency[np.argmax(magnitude[1].get_ydata())] == pytest.approx(9.0, rel=0.05)


def test_the_unevenness_figure_marks_what_is_extrapolated(results):
    figure = track_plots.unevenness(results, ["fra-hamid-yang-3"])
    curve, outside = figure.axes[0].lines
    np.testing.assert_allclose(curve.get_ydata(), 10.0 * np.log10(1e-7 * curve.get_xdata() ** 2 * 1e12))
    assert outside.get_xdata().max() < 1.524


def test_the_narrow_band_figure_shows_the_lines_of_the_database(study):
    directory = study.write()
    ingest(directory)
    with connect(directory) as connection:
        (drawing,) = [drawing for drawing in catalogue.drawings(connection) if "narrow-band" in drawing.name]
        figure = drawing.draw()
    reference, approach, *_ = figure.axes[0].lines
    assert reference.get_xdata().size == approach.get_xdata().size > 100
    # Without the ripple of the full model the two are 1 dB apart.
    ripple = 1.0 + 0.8 * np.sin(2 * np.pi * reference.get_xdata() / 1.57)
    np.testing.assert_allclose(
        approach.get_ydata() - reference.get_ydata(), 1.0 - 10 * np.log10(ripple), atol=1e-9
    )


def test_without_lines_in_the_database_there_is_no_narrow_band_figure(study):
    directory = study.write(narrow_band="none")
    ingest(directory)
    assert names(directory) == [name for name in PAPER if "narrow-band" not in name]


@pytest.mark.parametrize(("kind", "start"), [("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_figures_come_in_forms_for_print(study, kind, start):
    directory = study.write(lost=("moving-roughness", "moving-roughness-uncorrelated", "full"))
    result = CliRunner().invoke(cli.figures, [str(directory), "--format", kind])
    assert result.exit_code == 0, result.output
    published = [Path(line) for line in result.output.splitlines()]
    assert [path.name for path in published] == [f"{name}.{kind}" for name in PAPER[:3]]
    assert all(path.read_bytes().startswith(start) for path in published)


def test_every_axis_names_its_unit(paper):
    with connect(paper) as connection:
        for drawing in catalogue.drawings(connection, every=True):
            axes = [axis for axis in drawing.draw().axes if axis.get_visible()]
            assert any("[" in axis.get_xlabel() for axis in axes), drawing.name
            assert any("[" in axis.get_ylabel() for axis in axes), drawing.name
            if drawing.name in PAPER:
                assert all(axis.get_xscale() == "log" for axis in axes), drawing.name


def test_beyond_the_paper_there_are_distance_error_and_cost(results):
    named = [drawing.name for drawing in catalogue.drawings(results, every=True)]
    assert named[len(PAPER) :] == [
        "figure-11-distance",
        "figure-12-error-moving-roughness",
        "figure-12-error-moving-roughness-uncorrelated",
        "figure-13-cost",
    ]


def test_the_distance_figure_sums_bands_in_energy(results):
    figure = level_plots.distance(results, {"horstwalde": "case-0-150"}, ["full"])
    total = 10 * np.log10(np.sum(10 ** ((60.0 - 5.0 * 3 - 0.1 * BANDS) / 10)))
    np.testing.assert_allclose(lines(figure.axes[0])["#000000"], [total, total - 5.0, total - 10.0])
    at = [f"{band:g}" for band in (8, 16, 31.5, 63)]
    assert [axis.get_title(loc="left").partition(") ")[2].split(", ")[0] for axis in figure.axes[1:]] == [
        f"{b} Hz" for b in at
    ]


def test_the_error_map_shows_error_by_distance_or_speed(results, study):
    figure = error_plots.error_map(results, ["greby"], "moving-roughness-uncorrelated", "full")
    (mesh,) = figure.axes[0].collections
    np.testing.assert_allclose(mesh.get_array(), np.full((3, BANDS.size), 3.0))
    directory = study.write(soils=("greby",), speeds=(100.0, 150.0), lines=10)
    ingest(directory)
    with connect(directory) as connection:
        figure = error_plots.error_map(connection, ["greby"], "moving-roughness", "full")
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == ["100", "150"]


def test_the_cost_figure_has_a_point_per_case_and_approach(results):
    figure = error_plots.cost(results, ["moving-roughness", "full"], "ground")
    close, exact = figure.axes[0].lines
    assert (list(close.get_xdata()), list(close.get_ydata())) == ([5.75] * 2, pytest.approx([1.0] * 2))
    assert (list(exact.get_xdata()), list(exact.get_ydata())) == ([7.5] * 2, [0.0] * 2)


def test_multiples_of_the_passing_frequency_are_marked(results):
    (drawing,) = [drawing for drawing in catalogue.drawings(results) if "narrow-band" in drawing.name]
    marked = [line.get_xdata()[0] for line in drawing.draw().axes[0].lines if line.get_color() == "#b9a7c9"]
    np.testing.assert_allclose(marked, np.arange(1, 9) * 150 / 3.6 / 26.6)


def test_names_are_not_read_as_mathematics(study):
    directory = study.write(soils=("$\\frac{a$", "_hidden"), lines=10)
    ingest(directory)
    assert len(draw(directory)) == len(PAPER)


def test_results_that_are_missing_leave_their_curve_out(study):
    directory = study.write(lost=("moving-roughness",))
    ingest(directory)
    with connect(directory) as connection:
        figure = level_plots.rail(connection, {"greby": "case-1-150"}, ["moving-roughness", "full"])
    assert set(lines(figure.axes[0])) == {"#000000", "white"}  # hollow markers: extrapolated unevenness


def test_a_run_without_any_result_has_the_figures_that_it_can_have(study):
    directory = study.write(lost=("moving-roughness", "moving-roughness-uncorrelated", "full"))
    ingest(directory)
    assert names(directory) == PAPER[:3]


def test_figures_on_panels_that_have_been_drawn_on_are_the_same(results, tmp_path):
    drawings = catalogue.drawings(results, every=True)

    def pictures(order, kept):
        made = {}
        for drawing in order:
            if not kept:
                appearance._emptied.clear()
            write(drawing, tmp_path, "png")
            made[drawing.name] = (tmp_path / f"{drawing.name}.png").read_bytes()
        return made

    fresh = pictures(drawings, kept=False)
    assert pictures(drawings, kept=True) == fresh == pictures(drawings[::-1], kept=True)


def test_panels_with_more_than_curves_are_not_drawn_on_again():
    taken = appearance.page(3, 2)[0]
    taken.axes[0].pcolormesh(np.ones((2, 2)))
    other = appearance.page(3, 2)[0]
    other.axes[0].plot([1.0, 2.0], [3.0, 4.0])
    for figure in (taken, other):
        appearance.take_back(figure)
    assert appearance.page(3, 2)[0] is other
    assert appearance.page(3, 2)[0] is not taken
    assert not other.axes[0].lines
