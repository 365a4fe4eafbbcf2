"""Views against numbers computed by hand from the study of `run_directory`."""

import math

import duckdb
import pytest

from benchmarks.runs.invented import BANDS, COSTS
from queries.database import DATABASE, connect, ingest


def test_levels_are_decibels_re_the_standard_references(results):
    found = results.execute(
        "SELECT receiver, level_db, reference_value FROM levels WHERE soil = 'greby' AND approach = 'full' "
        "AND contribution = 'dynamic' AND band_hz BETWEEN 9.9 AND 10.1 AND offset_m IS NOT DISTINCT FROM "
        "NULL "
        "ORDER BY receiver"
    ).fetchall()
    assert [row[0] for row in found] == ["axle-1", "axle-2", "rail"]
    # 60 dB + 10 dB for the second soil − 5 dB per receiver − 0.1 dB/Hz × 10 Hz.
    assert [row[1] for row in found] == pytest.approx([69.0, 64.0, 59.0])
    assert [row[2] for row in found] == [1.0, 1.0, 1e-9]


def test_a_velocity_of_one_nanometre_per_second_is_zero_decibels(results):
    assert results.execute("SELECT decibel(1e-18 * 1e18), decibel(100.0)").fetchone() == (0.0, 20.0)
    nothing = results.execute(
        "SELECT decibel(0.0), decibel('nan'::DOUBLE), decibel('inf'::DOUBLE)"
    ).fetchone()
    assert nothing == (None, None, None)


def test_accuracy_is_approach_minus_reference(results):
    found = results.execute(
        "SELECT approach, min(error_db), max(error_db), count(*), any_value(reference) FROM accuracy "
        "GROUP BY approach ORDER BY approach"
    ).fetchall()
    rows = 2 * 2 * 6 * BANDS.size
    assert found[0] == ("moving-roughness", pytest.approx(1.0), pytest.approx(1.0), rows, "full")
    assert found[1] == (
        "moving-roughness-uncorrelated",
        pytest.approx(-3.0),
        pytest.approx(-3.0),
        rows,
        "full",
    )


def test_accuracy_says_both_levels(results):
    worst = results.execute(
        "SELECT max(abs(level_db - reference_level_db - error_db)) FROM accuracy"
    ).fetchone()
    assert worst[0] < 1e-9


def test_a_case_without_reference_has_no_error(study):
    directory = study.write(lost=("full",))
    ingest(directory)
    with connect(directory) as connection:
        assert connection.execute("SELECT count(*) FROM accuracy").fetchone() == (0,)
        assert connection.execute("SELECT count(*) FROM tradeoff").fetchone() == (0,)
        assert connection.execute("SELECT count(DISTINCT approach) FROM levels").fetchone() == (2,)
        found = connection.execute("SELECT soil, approach, scope, error FROM missing ORDER BY ALL").fetchall()
    assert found == [
        (soil, "full", "case", "ArithmeticError: no <b>solution</b>") for soil in ("greby", "horstwalde")
    ]


def test_a_band_without_energy_has_no_level_and_no_error(study):
    directory = study.write(zero_band=True)
    ingest(directory)
    with connect(directory) as connection:
        assert connection.execute("SELECT DISTINCT level_db FROM levels WHERE band_hz = 1").fetchall() == [
            (None,)
        ]
        assert connection.execute("SELECT min(band_hz) FROM accuracy").fetchone()[0] == pytest.approx(
            BANDS[1]
        )


def test_costs_charge_shared_work_in_full(results):
    found = results.execute(
        "SELECT approach, kind, cpu_s FROM costs WHERE case_id = 'case-0-150' ORDER BY ALL"
    ).fetchall()
    assert found == [
        (approach, kind, COSTS[approach if kind == "spectra" else kind])
        for approach in ("full", "moving-roughness", "moving-roughness-uncorrelated")
        for kind in ("fit", "receptance", "spectra", "transfer")
    ]


def test_runtime_sums_costs_and_shows_what_one_more_speed_adds(results):
    found = results.execute(
        "SELECT cpu_s, wall_s, evaluations, marginal_speed_cpu_s, marginal_speed_evaluations, speed_up, "
        "marginal_speed_up, missing_units FROM runtime WHERE soil = 'horstwalde' ORDER BY approach"
    ).fetchall()
    # full: 1 + 4 + 0.5 + 2, of which 0.5 + 2 belong to the speed; the others 1 + 4 + 0.5 + 0.25.
    assert found[0] == (7.5, 15.0, 7500, 2.5, 2500, 1.0, 1.0, 0)
    assert found[1] == (5.75, 11.5, 5750, 0.25, 250, pytest.approx(7.5 / 5.75), 10.0, 0)


def test_runtime_shows_no_speed_up_where_work_is_missing(study):
    directory = study.write(lost=("moving-roughness",))
    ingest(directory)
    with connect(directory) as connection:
        found = connection.execute(
            "SELECT missing_units, speed_up FROM runtime WHERE soil = 'greby' AND approach = "
            "'moving-roughness'"
        ).fetchone()
    assert found == (1, None)


def test_runtimes_of_different_kinds_of_hosts_are_not_compared(study):
    study.write(approaches=("full",), host_class="old")
    directory = study.write(run_id="run-2", started="2026-03-02T08:00:00+00:00", host_class="new")
    ingest(directory)
    with connect(directory) as connection:
        found = connection.execute(
            "SELECT approach, host_class, speed_up FROM runtime WHERE soil = 'greby' ORDER BY ALL"
        ).fetchall()
    assert found == [
        ("full", "old", 1.0),
        ("moving-roughness", None, None),
        ("moving-roughness-uncorrelated", None, None),
    ]


def test_tradeoff_sets_error_beside_cost(results):
    found = results.execute(
        "SELECT place, mean_error_db, mean_absolute_error_db, largest_absolute_error_db, cpu_s FROM tradeoff "
        "WHERE soil = 'greby' AND approach = 'moving-roughness-uncorrelated' AND contribution = 'dynamic' "
        "AND quantity = 'velocity' ORDER BY place"
    ).fetchall()
    error = (pytest.approx(-3.0), pytest.approx(3.0), pytest.approx(3.0), 5.75)
    assert found == [("ground", *error), ("rail", *error)]


def test_compare_sets_any_two_approaches_against_each_other(results):
    found = results.execute(
        "SELECT min(difference_db), max(difference_db), count(*), max(abs(a_level_db - b_level_db - "
        "difference_db)) "
        "FROM compare('moving-roughness', 'moving-roughness-uncorrelated')"
    ).fetchone()
    assert found[:2] == (pytest.approx(4.0), pytest.approx(4.0))
    assert found[2] == 2 * 2 * 6 * BANDS.size
    assert found[3] < 1e-9


def test_compare_takes_names_as_data(results):
    assert results.execute("FROM compare($1, $2)", ["full'; DROP TABLE cases; --", "full"]).fetchall() == []


def test_views_show_the_newest_run_of_each_case(study):
    study.write(speeds=(150.0, 200.0))
    directory = study.write(run_id="run-2", started="2026-03-02T08:00:00+00:00", speeds=(150.0,))
    ingest(directory)
    with connect(directory) as connection:
        found = connection.execute("SELECT DISTINCT speed_kmh, run_id FROM levels ORDER BY ALL").fetchall()
        doubled = connection.execute(
            "SELECT count(*) FROM levels GROUP BY case_id, approach, contribution, receiver, offset_m, "
            "band_hz "
            "HAVING count(*) > 1"
        ).fetchall()
    assert found == [(150.0, "run-2"), (200.0, "run-1")]
    assert doubled == []


def test_an_approach_that_the_newest_run_dropped_is_not_shown(study):
    study.write()
    directory = study.write(
        run_id="run-2", started="2026-03-02T08:00:00+00:00", approaches=("moving-roughness", "full")
    )
    ingest(directory)
    with connect(directory) as connection:
        assert connection.execute("SELECT DISTINCT approach FROM accuracy").fetchall() == [
            ("moving-roughness",)
        ]


def test_parameters_can_group_results(results):
    found = results.execute(
        "SELECT layer, thickness_m, shear_speed_m_s FROM cases JOIN soil_layers USING (soil_id) "
        "WHERE cases.soil = 'greby' ORDER BY layer"
    ).fetchall()
    assert found == [(1, 2.0, 250.0), (2, None, 311.0)]
    assert results.execute("SELECT vehicles, axles, length_m FROM trains").fetchall() == [(4, 16, 106.4)]
    assert results.execute("SELECT stiffness_n_m2 FROM track_layers").fetchall() == [(4.64e9,)]
    assert results.execute("SELECT form FROM unevenness").fetchall() == [("fra-hamid-yang",)]


def test_axles_are_numbered_from_the_head_of_the_train(results):
    places = [row[0] for row in results.execute(
        "SELECT behind_first_axle_m FROM axles ORDER BY vehicle, "
        "behind_first_axle_m").fetchall()]  # fmt: skip
    assert places[:5] == pytest.approx([0.0, 2.7, 19.0, 21.7, 26.6])
    assert math.isclose(places[-1], 101.5)


def floored(study, factor):
    """Return a study whose quasi-static mean squares on the ground are so many times the dynamic ones."""
    directory = study.write(soils=("clay",), lines=10)
    ingest(directory)
    with duckdb.connect(str(directory / DATABASE)) as connection:
        connection.execute(
            "INSERT INTO bands SELECT * REPLACE ('quasi-static' AS contribution, mean_square * $1 AS "
            "mean_square) FROM bands WHERE receiver = 'ground' AND contribution = 'dynamic'",
            [factor],
        )
    return directory


@pytest.mark.parametrize(("factor", "levels"), [(1e-18, True), (1e-22, False)])
def test_a_level_far_below_the_largest_of_its_receiver_is_none(study, factor, levels):
    with connect(floored(study, factor)) as connection:
        found = connection.execute(
            "SELECT contribution, count(*), count(level_db) FROM levels WHERE receiver = 'ground' "
            "GROUP BY ALL ORDER BY ALL"
        ).fetchall()
        errors = connection.execute(
            "SELECT count(error_db) FROM accuracy WHERE contribution = 'quasi-static'"
        ).fetchone()
        differences = connection.execute(
            "SELECT count(difference_db) FROM compare('moving-roughness', 'full') "
            "WHERE contribution = 'quasi-static'"
        ).fetchone()
    rows = 3 * 3 * BANDS.size
    assert found == [
        ("dynamic", rows, rows),
        ("quasi-static", rows, rows * levels),
        ("total", rows, rows),
    ]
    assert errors == (rows * 2 // 3 * levels,)
    assert differences == (rows // 3 * levels,)


def test_the_peak_of_a_receiver_is_that_of_all_its_contributions(results):
    found = results.execute(
        "SELECT count(*) FROM (SELECT peak_mean_square, max(mean_square) OVER (PARTITION BY case_id, "
        "approach, quantity, receiver, offset_m, averaging) AS peak FROM bands) "
        "WHERE peak_mean_square <> peak"
    ).fetchone()
    assert found == (0,)
