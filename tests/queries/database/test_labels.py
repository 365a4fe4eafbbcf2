"""Two names for equal things are two labels of one case, and results appear under both."""

import pytest

from benchmarks.runs.invented import BANDS, Study
from queries.answers import error_table, named_cases, pairs
from queries.database import connect, ingest
from queries.figures import catalogue
from queries.report.data import data
from sweep.storage import records

LATER = "2026-03-02T08:00:00+00:00"
NAMES = {
    "soil": ("horstwalde", "sand"),
    "track": ("ballasted-paper", "ours"),
    "train": ("grona-taget", "x50"),
    "unevenness": ("fra-hamid-yang-3", "good"),
}
VIEWS = ("levels", "run_levels", "accuracy", "runtime", "tradeoff", "case_parameters")


def counts(connection, kind):
    """Return the rows of each view by name of one kind of thing."""
    return {
        view: dict(connection.execute(f"SELECT {kind}, count(*) FROM {view} GROUP BY ALL").fetchall())
        for view in VIEWS
    }


@pytest.mark.parametrize("kind", NAMES)
def test_every_view_has_the_rows_of_a_case_under_each_of_its_names(tmp_path, kind):
    first, second = NAMES[kind]
    alone, twice = (tmp_path / name for name in ("alone", "twice"))
    ingest(Study(alone).write(soils=("horstwalde",), lines=10))
    ingest(Study(twice).write(soils=("horstwalde",), lines=10, aliases={first: second}))
    with connect(alone) as connection:
        expected = {view: rows[first] for view, rows in counts(connection, kind).items()}
    with connect(twice) as connection:
        found = counts(connection, kind)
        assert found == {view: {first: rows, second: rows} for view, rows in expected.items()}
        pair = connection.execute(
            f"SELECT {kind}, count(*) FROM compare('moving-roughness', 'full') GROUP BY ALL"
        )
        assert dict(pair.fetchall()) == dict.fromkeys((first, second), 2 * 6 * BANDS.size)
        assert connection.execute("SELECT count(*) FROM bands").fetchone() == (3 * 2 * 6 * BANDS.size,)


def test_tables_figures_and_page_show_both_names(tmp_path):
    directory = Study(tmp_path / "run").write(lines=10, aliases={"horstwalde": "sand"})
    ingest(directory)
    with connect(directory) as connection:
        soils = [case.soil for case in named_cases(connection)]
        assert sorted(soils) == ["greby", "horstwalde", "sand"]
        table = error_table(connection, pairs(connection)[0])
        assert {row[0] for row in table.rows} == set(soils)
        names = [drawing.name for drawing in catalogue.drawings(connection)]
        assert {"figure-04-receptance-horstwalde", "figure-05-receptance-sand"} <= set(names)
        page = data(connection)
    assert page["axes"]["soil"] == soils
    assert len(page["cases"]) == 3
    assert sorted({case for case, *_ in page["costs"]}) == [0, 1, 2]


def test_a_name_that_another_run_gives_is_one_more_label(study):
    study.write(soils=("horstwalde",), lines=10)
    directory = study.write(soils=("sand",), lines=10, run_id="run-2", started=LATER)
    ingest(directory)
    with connect(directory) as connection:
        found = connection.execute("SELECT DISTINCT soil, run_id FROM levels ORDER BY ALL").fetchall()
    assert found == [("horstwalde", "run-2"), ("sand", "run-2")]


def test_a_name_of_another_directory_is_one_more_label_and_stays(tmp_path):
    path = tmp_path / "all.duckdb"
    one = Study(tmp_path / "one").write(soils=("horstwalde",), lines=10)
    other = Study(tmp_path / "other").write(soils=("sand",), lines=10, run_id="run-2", started=LATER)
    for directory in (one, other):
        ingest(directory, file=path)
    Study(one).write(soils=("horstwalde",), lines=10, run_id="run-3", started="2026-03-03T08:00:00+00:00")
    ingest(one, file=path)
    with connect(path) as connection:
        found = connection.execute("SELECT DISTINCT soil FROM accuracy ORDER BY soil").fetchall()
    assert found == [("horstwalde",), ("sand",)]


def test_a_manifest_without_labels_has_the_names_of_its_cases(study):
    directory = study.write(lines=10)
    manifest = records.Run.load(directory)
    for case in manifest["cases"]:
        del case["labels"]
    del manifest["axles"]
    records.Run.publish(directory, manifest)
    ingest(directory)
    with connect(directory) as connection:
        assert connection.execute("SELECT soil FROM cases ORDER BY soil").fetchall() == [
            ("greby",),
            ("horstwalde",),
        ]
        axles = connection.execute("SELECT receiver, vehicle, axle_load_n FROM axles LIMIT 5").fetchall()
        places = connection.execute("SELECT DISTINCT behind_first_axle_m FROM axles").fetchall()
    assert axles == [(f"axle-{axle}", 1 + (axle - 1) // 4, 140.1e3) for axle in range(1, 6)]
    assert places == [(None,)]


def test_a_name_with_a_new_meaning_is_shown_as_the_newest_run_means_it(study):
    directory = study.write(soils=("clay",), lines=10)
    manifest = records.Run.load(directory) | {"run_id": "run-2", "started": LATER}
    manifest["cases"][0]["case_id"] = "another-case"
    records.Run.publish(directory, manifest)
    ingest(directory)
    with connect(directory) as connection:
        assert [case.case_id for case in named_cases(connection)] == ["another-case"]
        assert data(connection)["cases"] == [[0, 0, 0, 0, 0]]
