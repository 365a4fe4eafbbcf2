"""Questions with a name answer what their sentence says."""

import csv
import io
import math

import pytest
from click.testing import CliRunner

import queries
from benchmarks.runs.invented import BANDS, mean_square
from queries import cli
from queries.answers.questions import questions
from queries.database import DATABASE, ingest

SHIPPED = {
    "axle-correlation-by-band",
    "cases-that-exceed",
    "cost-against-error",
    "error-against-distance",
    "error-against-relative-speed",
    "error-of-passages",
    "largest-error-by-band",
    "passages-that-exceed",
    "quasi-static-share",
    "rms-from-lines",
    "speed-up-by-study-size",
    "strongest-lines",
    "wheel-share",
}
SILENT = {"quasi-static-share", "wheel-share", "error-of-passages", "passages-that-exceed"}
"""Of the paper's case, which has smooth wheels and no levels of passages, these say nothing."""


def ask(name, directory, *arguments):
    result = CliRunner().invoke(cli.queries, [name, str(directory), "--format", "csv", *arguments])
    assert result.exit_code == 0, result.output
    return list(csv.DictReader(io.StringIO(result.output)))


def test_each_shipped_question_has_a_sentence_and_is_listed():
    listed = CliRunner().invoke(cli.queries, [])
    assert listed.exit_code == 0
    assert set(questions()) == SHIPPED
    for question in questions().values():
        assert question.sentence.count("?") == 1
        assert question.name in listed.output
        assert question.sentence in listed.output


def test_its_sql_is_shown_with_its_parameters():
    shown = CliRunner().invoke(cli.queries, ["cases-that-exceed"]).output
    assert "-- $level_db = 80.0: level that is exceeded" in shown
    assert "level_db > $level_db" in shown


@pytest.mark.parametrize(
    "name",
    sorted(SHIPPED - SILENT),
)
def test_every_shipped_question_has_an_answer(paper, name):
    arguments = ["--set", "level_db=30"] if name == "cases-that-exceed" else []
    assert len(ask(name, paper, *arguments)) > 0


def test_largest_error_by_band(paper):
    found = ask("largest-error-by-band", paper)
    expected = {"moving-roughness": 1.0, "moving-roughness-uncorrelated": -3.0}
    assert all(float(row["largest_error_db"]) == expected[row["approach"]] for row in found)
    # Two soils; two axles, the rail, the ground at three offsets.
    for place, values in (("force", "4"), ("rail", "2"), ("ground", "6")):
        rows = [row for row in found if (row["approach"], row["place"]) == ("moving-roughness", place)]
        assert [float(row["band_hz"]) for row in rows] == pytest.approx(BANDS, abs=0.01)
        assert {row["values"] for row in rows} == {values}


def test_speed_relative_to_the_rayleigh_speed(study):
    from sweep.storage import records

    directory = study.write(soils=("clay",), lines=10)
    manifest = records.Run.load(directory) | {"rayleigh_speeds_m_s": {"clay": [100.0, 200.0]}}
    records.Run.publish(directory, manifest)
    ingest(directory)
    (row, _) = ask("error-against-relative-speed", directory)
    assert float(row["speed_over_rayleigh_speed"]) == pytest.approx(150 / 3.6 / 100, abs=1e-3)
    assert float(row["mean_error_db"]) == 1.0


def test_error_against_distance(paper):
    found = ask("error-against-distance", paper)
    assert [row["offset_m"] for row in found[:3]] == ["0.0", "8.0", "32.0"]
    assert {(row["approach"], row["mean_error_db"]) for row in found} == {
        ("moving-roughness", "1.0"),
        ("moving-roughness-uncorrelated", "-3.0"),
    }


def test_pareto_front_has_no_point_that_another_beats(paper):
    found = {
        row["approach"]: (row["cpu_s"], row["mean_absolute_error_db"], row["pareto"])
        for row in ask("cost-against-error", paper)
        if row["soil"] == "greby"
    }
    assert found == {
        "moving-roughness": ("5.75", "1.0", "True"),
        "moving-roughness-uncorrelated": ("5.75", "3.0", "False"),
        "full": ("7.5", "0.0", "True"),
    }


def test_cost_is_set_against_the_error_of_one_place(study):
    import duckdb

    directory = study.write(soils=("clay",), lines=10)
    ingest(directory)
    with duckdb.connect(str(directory / DATABASE)) as connection:
        connection.execute(
            "UPDATE bands SET mean_square = mean_square * 10 ** 0.4 WHERE receiver = 'rail' "
            "AND approach = 'moving-roughness'"
        )
    for setting, error in (
        ("place=ground", "1.0"),
        ("place=rail", "5.0"),
        ("quantity=wheel_rail_force", "1.0"),
    ):
        rows = {row["approach"]: row for row in ask("cost-against-error", directory, "--set", setting)}
        assert rows["moving-roughness"]["mean_absolute_error_db"] == error
        assert rows["moving-roughness"]["largest_absolute_error_db"] == error
        assert len(rows) == 3


def test_shared_work_is_paid_once_as_a_study_grows(study):
    directory = study.write(soils=("clay",), speeds=(100.0, 150.0, 200.0), lines=10)
    ingest(directory)
    found = [row for row in ask("speed-up-by-study-size", directory) if row["approach"] == "moving-roughness"]
    # fit 1 + transfer 4 + receptance 0.5 once, 0.25 per case; the full model pays 0.5 + 2 at each speed.
    expected = [((5.5 + 0.25 * n), (5.0 + 2.5 * n)) for n in (1, 2, 3)]
    assert [(float(row["cpu_s"]), float(row["reference_cpu_s"])) for row in found] == expected
    assert [float(row["speed_up"]) for row in found] == [round(b / a, 2) for a, b in expected]


def test_cases_that_exceed_a_level(paper):
    found = ask("cases-that-exceed", paper, "--set", "level_db=48", "--set", "receiver=rail")
    level = 10 * math.log10(mean_square(1, 1.0, 2)[0] * 1e18)
    best = max(found, key=lambda row: float(row["above_db"]))
    assert (best["soil"], best["approach"]) == ("greby", "moving-roughness")
    assert float(best["above_db"]) == pytest.approx(level - 48, abs=0.051)
    assert ask("cases-that-exceed", paper, "--set", "level_db=200") == []


def test_axle_correlation_is_correlated_minus_uncorrelated(paper):
    found = ask("axle-correlation-by-band", paper)
    assert {row["mean_effect_db"] for row in found} == {"4.0"}
    assert len(found) == 6 * BANDS.size


def test_quasi_static_share_is_one_of_energies(study):
    import duckdb

    directory = study.write(soils=("clay",), lines=10)
    ingest(directory)
    with duckdb.connect(str(directory / DATABASE)) as connection:
        connection.execute(
            "UPDATE bands SET contribution = 'quasi-static', mean_square = mean_square / 4 WHERE "
            "contribution = 'dynamic'"
        )
    found = ask("quasi-static-share", directory)
    assert {row["quasi_static_share"] for row in found} == {"0.25"}
    assert {row["quasi_static_over_total_db"] for row in found} == {"-6.0"}


def test_wheel_share_is_one_of_dynamic_energies(study):
    import duckdb

    directory = study.write(soils=("clay",), lines=10)
    ingest(directory)
    assert ask("wheel-share", directory) == []
    with duckdb.connect(str(directory / DATABASE)) as connection:
        connection.execute("CREATE TABLE dynamic AS FROM bands WHERE contribution = 'dynamic'")
        connection.execute("UPDATE dynamic SET contribution = 'wheels', mean_square = 0.9 * mean_square")
        connection.execute("INSERT INTO bands FROM dynamic")
    found = ask("wheel-share", directory)
    assert {row["receiver"] for row in found} == {"axle-1", "rail", "ground"}
    assert {row["wheel_share"] for row in found} == {"0.9"}
    assert {row["wheels_add_db"] for row in found} == {"10.0"}


def test_own_questions_stand_beside_the_shipped_ones(paper, tmp_path):
    (tmp_path / "mine.sql").write_text(
        "-- How many cases are faster than this?\n-- $speed_kmh = 100: speed, km/h\n"
        "SELECT count(*) AS n FROM cases WHERE speed_kmh > $speed_kmh\n"
    )
    arguments = ("--folder", str(tmp_path))
    assert ask("mine", paper, *arguments) == [{"n": "2"}]
    assert ask("mine", paper, *arguments, "--set", "speed_kmh=150") == [{"n": "0"}]
    listed = CliRunner().invoke(cli.queries, [], env={"RAILVIB_QUERIES": str(tmp_path)}).output
    assert "How many cases are faster than this?" in listed
    with queries.open(paper) as results:
        assert results.ask("mine", tmp_path, speed_kmh=150).n.tolist() == [0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("SELECT 1", "must begin with a comment"),
        ("-- What?\n-- $a = [1]: b\nSELECT $a", "must be a number or a 'text'"),
        ("-- What?\nDROP TABLE bands", "only statements that read"),
        ("-- What?\nSELECT 1; SELECT 2", "one statement is expected"),
    ],
)
def test_an_own_question_that_is_wrong_is_refused_in_one_line(paper, tmp_path, text, said):
    (tmp_path / "mine.sql").write_text(text)
    result = CliRunner().invoke(cli.queries, ["mine", str(paper), "--folder", str(tmp_path)])
    assert result.exit_code == 2
    assert said in result.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing"], "no such question"),
        (["cases-that-exceed", "RUN", "--set", "level=1"], "no such parameter; it has: level_db"),
        (["cases-that-exceed", "RUN", "--set", "level_db=high"], "must be a number"),
        (["cases-that-exceed", "RUN", "--set", "level_db"], "NAME=VALUE"),
        (["--folder", "/no/such/folder"], "no such folder"),
    ],
)
def test_a_wrong_request_is_refused_in_one_line(paper, arguments, said):
    result = CliRunner().invoke(
        cli.queries, [str(paper) if argument == "RUN" else argument for argument in arguments]
    )
    assert result.exit_code == 2
    assert said in result.stderr


def test_a_value_is_data(paper):
    assert ask("cases-that-exceed", paper, "--set", "receiver='; DROP TABLE cases; --") == []
