"""Tables and sentences say what the database says, and nothing else."""

import duckdb
import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.runs.invented import BANDS, RECEIVERS, Study
from queries import cli
from queries.answers.comparison import Pair
from queries.answers.errors import error_table, errors
from queries.answers.summary import extrapolation_notes, missing_notes, summary, verdicts
from queries.answers.table import band, decibels, number
from queries.database import DATABASE, ResultsError, connect, ingest

PAIR = Pair.of_approaches("moving-roughness", "full")


def change(directory, statement):
    """Change a database that is otherwise only read."""
    with duckdb.connect(str(directory / DATABASE)) as connection:
        connection.execute(statement)


def shown(directory, *arguments):
    return CliRunner().invoke(cli.compare, [str(directory), *arguments])


@pytest.fixture
def run(study):
    ingest(study.write())
    return study.directory


def test_errors_are_grouped_in_the_order_of_study_and_distance(results):
    found = errors(results, PAIR)
    places = ["force, all axles", "rail", "ground at 0 m", "ground at 8 m", "ground at 32 m"]
    assert [error.group for error in found] == [
        (soil, 150.0, place) for soil in ("horstwalde", "greby") for place in places
    ]
    assert [error.bands for error in found] == [2 * BANDS.size, *[BANDS.size] * 4] * 2
    assert [error.mean for error in found] == pytest.approx([1.0] * 10)


def test_mean_size_and_largest_error_are_those_of_the_rows(run):
    # Two bands of the rail on Greby: +10 dB and −20 dB on top of the +1 dB of every band.
    for at, factor in ((BANDS[3], 10.0), (BANDS[5], 0.01)):
        change(
            run,
            f"UPDATE bands SET mean_square = mean_square * {factor} WHERE case_id = 'case-1-150' AND "
            "receiver = 'rail' "
            f"AND contribution = 'dynamic' AND approach = 'moving-roughness' AND abs(band_hz - {at}) < 1e-9",
        )
    with connect(run) as connection:
        (error,) = [error for error in errors(connection, PAIR) if error.group == ("greby", 150.0, "rail")]
    assert error.mean == pytest.approx((19 * 1.0 + 11.0 - 19.0) / 21)
    assert error.mean_absolute == pytest.approx((19 * 1.0 + 11.0 + 19.0) / 21)
    assert error.largest == pytest.approx(-19.0)
    assert error.largest_band_hz == pytest.approx(BANDS[5])


def test_a_changed_row_changes_what_compare_shows(run):
    before = shown(run).output
    assert "-34.0" not in before
    change(
        run,
        "UPDATE bands SET mean_square = mean_square * 10 ** -3.5 WHERE case_id = 'case-1-150' AND receiver "
        "= 'rail' "
        "AND contribution = 'dynamic' AND approach = 'moving-roughness' AND band_hz > 99",
    )
    (line,) = [line for line in shown(run).output.splitlines() if "-34.0" in line]
    assert line.split() == ["greby", "rail", "-0.7", "2.6", "-34.0", "100"]


def test_compare_shows_errors_costs_and_places(run):
    output = shown(run).output
    assert "Error of moving-roughness against full, 150 km/h" in output
    assert "Error of moving-roughness-uncorrelated against full, 150 km/h" in output
    (cost,) = [line for line in output.splitlines() if "greby" in line and "full" in line]
    assert cost.split() == ["greby", "full", "7,500", "7.50", "15.0", "1.0", "×", "2.50", "1.0", "×"]
    for place in ("transfer_functions.zarr", "results.duckdb"):
        assert str(run / place) in output


def test_compare_takes_any_pair(run):
    output = shown(run, "full", "moving-roughness-uncorrelated").output
    assert "Error of full against moving-roughness-uncorrelated" in output
    assert "+3.0" in output
    assert "Error of moving-roughness " not in output


def test_compare_takes_the_reference_of_the_study_by_default(run):
    assert "Error of moving-roughness against full" in shown(run, "moving-roughness").output


def test_compare_refuses_an_unknown_approach(run):
    done = shown(run, "moving-roughnes")
    assert done.exit_code == 2
    assert "moving-roughnes: no such approach" in done.stderr


def test_compare_makes_the_database_that_is_not_there_yet(study):
    directory = study.write()
    assert shown(directory).exit_code == 0
    assert (directory / DATABASE).is_file()


def test_another_contribution_can_be_compared(run):
    change(
        run,
        "UPDATE bands SET mean_square = mean_square * 10 WHERE contribution = 'total' AND approach = 'full'",
    )
    assert "-9.0" in shown(run, "--contribution", "total").output
    assert "-9.0" not in shown(run).output


def test_speeds_get_a_column_where_they_differ(study):
    directory = study.write(speeds=(100.0, 150.0))
    output = shown(directory).output
    assert "speed [km/h]" in output
    assert "100 " in output


def test_many_cases_are_shown_together(study):
    directory = study.write(speeds=tuple(range(60, 270, 30)), lines=10)
    output = shown(directory).output
    assert "mean over all cases" in output
    assert "horstwalde" not in output


def test_errors_by_band(results):
    found = errors(results, PAIR, by=("band",))
    np.testing.assert_allclose([error.group[0] for error in found], BANDS)


def test_an_unknown_grouping_is_refused(results):
    with pytest.raises(ResultsError, match="cannot be grouped"):
        errors(results, PAIR, by=("soil; DROP TABLE cases",))


def test_the_summary_states_error_and_cost(results):
    first, second = summary(results)
    assert first.startswith("Moving roughness is 1.0 dB from the full model on average where it is furthest")
    assert first.endswith(
        "It costs 5.75 CPU seconds per case, 1.3 times less than the full model; "
        "one more speed costs 0.250 CPU seconds, 10 times less than the full model."
    )
    assert second.startswith("Moving roughness, uncorrelated axles is 3.0 dB from the full model")


def test_the_glance_says_from_which_band_up_an_approach_may_be_trusted(run):
    # Below 8 Hz the rail's error grows to 5 dB.
    change(
        run,
        "UPDATE bands SET mean_square = mean_square * 10 ** 0.4 WHERE receiver = 'rail' "
        "AND approach = 'moving-roughness' AND band_hz < 7.9",
    )
    with connect(run) as connection:
        rows = [dict(zip(range(10), row, strict=False)) for row in verdicts(connection).rows]
    assert [row[0] for row in rows] == ["moving roughness", "moving roughness, uncorrelated axles"]
    assert [rows[0][n] for n in range(1, 7)] == ["1.0", "1 Hz", "2.7", "8 Hz", "1.0", "1 Hz"]
    assert [rows[0][n] for n in range(7, 10)] == ["5.75", "1.3 ×", "10 ×"]


def test_what_is_missing_is_said(study):
    directory = study.write(lost=("moving-roughness",))
    ingest(directory)
    with connect(directory) as connection:
        assert missing_notes(connection) == [
            "Missing: moving-roughness lacks results in 2 of 2 cases (ArithmeticError: no <b>solution</b>)."
        ]
        assert (
            "Moving roughness cannot be compared with the full model: no case has results of both."
            in summary(connection)
        )
    done = shown(directory)
    assert done.exit_code == 0
    assert "lacks results in 2 of 2 cases" in done.output


def test_a_reference_that_is_missing_in_some_cases_is_said(study):
    study.write()
    directory = study.write(
        run_id="run-2",
        started="2026-03-02T08:00:00+00:00",
        soils=("horstwalde",),
        speeds=(200.0,),
        lost=("full",),
    )
    ingest(directory)
    with connect(directory) as connection:
        table = error_table(connection, PAIR)
    assert "Only 2 of 3 cases have results of both." in table.note


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (float("nan"), "–"),
        (0.0, "0"),
        (1234567.0, "1,234,567"),
        (12.345, "12.3"),
        (0.00123456, "0.00123"),
    ],
)
def test_numbers_are_readable(value, text):
    assert number(value) == text


def test_bands_have_their_nominal_names():
    names = [band(value) for value in 10.0 ** (np.arange(-10, 21) / 10.0)]
    assert names[:11] == ["0.1", "0.125", "0.16", "0.2", "0.25", "0.315", "0.4", "0.5", "0.63", "0.8", "1"]
    assert names[-11:] == ["10", "12.5", "16", "20", "25", "31.5", "40", "50", "63", "80", "100"]


def test_decibels_carry_their_sign():
    assert [decibels(value) for value in (1.04, -0.26, -0.04, None)] == ["+1.0", "-0.3", "+0.0", "–"]


PLACES = {"force": 7.0, "rail": 5.0, "ground": 2.0}
"""Errors of the places at 8 Hz in the test below, dB."""


@pytest.fixture
def unlike(run):
    """Return results in which the error at 8 Hz differs between force, rail and ground."""
    for place, error in PLACES.items():
        change(
            run,
            f"UPDATE bands SET mean_square = mean_square * 10 ** {(error - 1.0) / 10} WHERE contribution = "
            f"'dynamic' AND approach = 'moving-roughness' AND abs(band_hz - {BANDS[9]}) < 1e-9 AND "
            f"place(quantity, receiver) = '{place}'",
        )
    return run


@pytest.mark.parametrize("by", ["band", "soil,band", "speed,band", "track,train,band"])
def test_quantities_and_places_are_never_pooled(unlike, by):
    output = shown(unlike, "moving-roughness", "--by", by).output
    assert (
        "Error of moving-roughness against full, 150 km/h: ground velocity at all offsets, dynamic" in output
    )
    rows = [line.split() for line in output.splitlines() if "+2.0" in line]
    assert all(row[-4:] == ["+2.0", "2.0", "+2.0", "8"] for row in rows)
    assert len(rows) == (2 if "soil" in by else 1)
    for other in ("+7.0", "+5.0", "+4.", "+3."):
        assert other not in output.partition("Cost per case")[0]


@pytest.mark.parametrize(
    ("receivers", "title", "error"),
    [
        ("rail", "rail velocity", "+5.0"),
        ("force", "wheel-rail force of all axles", "+7.0"),
        ("ground", "ground velocity at all offsets", "+2.0"),
        ("velocity", "velocity of rail and ground together", "+2.8"),  # (5 + 3 · 2) / 4
    ],
)
def test_other_receivers_are_averaged_where_they_are_asked_for(unlike, receivers, title, error):
    output = shown(unlike, "moving-roughness", "--by", "band", "--receivers", receivers).output
    assert f": {title}, dynamic" in output
    (row,) = [line.split() for line in output.splitlines() if line.split()[:1] == ["8"]]
    assert row[1] == error


def test_receivers_that_stand_apart_are_all_shown(unlike):
    output = shown(unlike, "moving-roughness", "--by", "receiver,band").output
    assert ": every receiver, dynamic" in output
    for error in ("+2.0", "+5.0", "+7.0"):
        assert error in output


def test_without_the_ground_the_rail_stands_for_a_case(tmp_path):
    receivers = [receiver for receiver in RECEIVERS if receiver[0] != "ground"]
    directory = Study(tmp_path / "run", receivers).write(lines=10)
    assert ": rail velocity, dynamic" in shown(directory, "--by", "band").output


def test_approaches_of_two_runs_are_never_pooled(unlike, tmp_path):
    other = Study(tmp_path / "other").write(lines=10, run_id="run-2")
    output = shown(unlike, "--with", str(other), "--by", "band").output
    rows = {
        tuple(line.split()[:2]): line.split()[2] for line in output.splitlines() if len(line.split()) == 6
    }
    assert rows["moving-roughness", "8"] == "+1.0"  # its error has become 1 dB more on the ground
    assert rows["full", "8"] == "+0.0"


def test_the_printed_summary_names_bands_on_extrapolated_unevenness(run):
    (sentence,) = [line for line in shown(run).output.splitlines() if line.startswith("Extrapolated")]
    assert sentence == (
        "Extrapolated: more than half of the unevenness fra-hamid-yang-3 lies outside its range of validity "
        "in 10 of 21 bands (12.5 to 100 Hz) at 150 km/h."
    )


def test_bands_that_do_not_follow_one_another_are_named_apart(run):
    change(
        run,
        "UPDATE bands SET extrapolated_share = CASE WHEN band_hz < 1.5 OR band_hz > 99 THEN 1 ELSE 0.5 END",
    )
    with connect(run) as connection:
        (sentence,) = extrapolation_notes(connection)
    assert "in 3 of 21 bands (1 to 1.25, 100 Hz)" in sentence


def test_unevenness_within_its_range_is_not_mentioned(run):
    change(run, "UPDATE bands SET extrapolated_share = NULL")
    with connect(run) as connection:
        assert extrapolation_notes(connection) == []
