"""The report is one file, says what the database says, and takes names as text."""

import html.parser
import re
import shutil

import duckdb
import pytest
from click.testing import CliRunner

import queries
from queries import cli, database, figures
from queries.database import ResultsError
from sweep import records


@pytest.fixture
def every_figure():
    """Ask for all figures; without it reports have the first one only, for drawing takes time."""


@pytest.fixture(autouse=True)
def _few_figures(request, monkeypatch):
    if "every_figure" not in request.fixturenames:
        drawings = figures.drawings
        monkeypatch.setattr(figures, "drawings", lambda *given: drawings(*given)[:1])


class Page(html.parser.HTMLParser):
    """Collects tags with their attributes, and all text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words, self.open = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in ("meta", "link", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.words.append(data)


def made(directory):
    done = CliRunner().invoke(cli.report, [str(directory)])
    assert done.exit_code == 0, done.output
    assert done.output.strip() == str(directory / "report.html")
    return (directory / "report.html").read_text(encoding="utf-8")


def test_the_report_stands_alone(study, every_figure):
    page = Page(made(study.write(lines=20)))
    assert page.open == []
    links = [
        value for _, attributes in page.tags for name, value in attributes.items() if name in ("src", "href")
    ]
    assert all(link.startswith("data:") for link in links)
    assert {tag for tag, _ in page.tags} & {"script", "iframe", "object"} == set()
    assert all(attributes["alt"] for tag, attributes in page.tags if tag == "img")


def test_the_report_has_summary_tables_and_provenance(study):
    words = " ".join(Page(made(study.write(lines=20))).words)
    for expected in (
        "moving-roughness differs from full by 1.0 dB on average",
        "Error of moving-roughness-uncorrelated against full",
        "Cost per case",
        "run-1",
        "x86_64-2",
        "numpy 2.4",
        "half-space",
    ):
        assert expected in words


def test_a_changed_row_changes_the_report(study):
    directory = study.write(lines=20)
    assert "-49.0" not in made(directory)
    with duckdb.connect(str(directory / database.DATABASE)) as connection:
        connection.execute(
            "UPDATE bands SET mean_square = mean_square * 1e-5 WHERE approach = 'moving-roughness' "
            "AND receiver = 'rail' AND contribution = 'dynamic' AND band_hz > 99"
        )
    assert "-49.0" in made(directory)


def test_names_are_text(study):
    soil, name = "<script>alert(1)</script>", '"><img src=x onerror=alert(1)>'
    page = Page(made(study.write(soils=(soil, "'; DROP TABLE cases; --"), name=name, lines=20)))
    assert "script" not in {tag for tag, _ in page.tags}
    assert not any("onerror" in attributes for _, attributes in page.tags)
    words = " ".join(page.words)
    assert soil in words
    assert name in words


def test_a_failure_is_said_in_the_report(study):
    words = " ".join(Page(made(study.write(lost=("full",), lines=20))).words)
    assert "full lacks results in 2 of 2 cases (ArithmeticError: no <b>solution</b>)" in words


def test_after_a_run_everything_is_there_and_shown(study, capsys):
    directory = study.write(lines=20)
    queries.after_run(directory)
    shown = capsys.readouterr().out
    assert "Error of moving-roughness against full" in shown
    for place in ("results.duckdb", "report.html", "figures", "transfer_functions.zarr"):
        assert (directory / place).exists()
        assert re.search(rf"{re.escape(str(directory / place))}$", shown, re.MULTILINE)


def test_after_a_run_that_added_nothing_figures_stay_and_the_report_names_the_run(study, capsys):
    directory = study.write(lines=20)
    queries.after_run(directory)
    before = {path: path.stat().st_mtime_ns for path in (directory / "figures").iterdir()}
    study.write(lines=20, run_id="run-2", started="2026-03-02T08:00:00+00:00")
    queries.after_run(directory)
    assert {path: path.stat().st_mtime_ns for path in (directory / "figures").iterdir()} == before
    report = directory / "report.html"
    assert "run-2" in report.read_text(encoding="utf-8")
    written = report.stat().st_mtime_ns
    queries.after_run(directory)
    assert report.stat().st_mtime_ns == written
    assert capsys.readouterr().out.count("Cost per case") == 3


def test_after_a_run_that_changed_results_figures_are_drawn_anew(study):
    directory = study.write(lines=20)
    queries.after_run(directory)
    before = (directory / "figures" / "figure-03-unevenness.png").stat().st_mtime_ns
    study.write(lines=20, run_id="run-2", started="2026-03-02T08:00:00+00:00", speeds=(150.0, 200.0))
    queries.after_run(directory)
    assert (directory / "figures" / "figure-03-unevenness.png").stat().st_mtime_ns > before


def test_figures_that_were_removed_come_back(study):
    directory = study.write(lines=20)
    queries.after_run(directory)
    shutil.rmtree(directory / "figures")
    (directory / "report.html").unlink()
    queries.after_run(directory)
    assert len(list((directory / "figures").iterdir())) == 1


@pytest.mark.parametrize("command", [cli.ingest, cli.compare, cli.report])
def test_a_directory_that_is_no_run_is_refused_in_one_line(command, tmp_path):
    for directory in (tmp_path, tmp_path / "nowhere"):
        done = CliRunner().invoke(command, [str(directory)])
        assert done.exit_code == 2
        assert done.stdout == ""
        assert len(done.stderr.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_ingest_says_what_it_did(study):
    directory = study.write(lines=20)
    runner = CliRunner()
    assert "written" in runner.invoke(cli.ingest, [str(directory)]).output
    assert "up to date" in runner.invoke(cli.ingest, [str(directory)]).output
    assert "written" in runner.invoke(cli.ingest, [str(directory), "--rebuild"]).output


def test_results_come_as_frames(paper):
    found = queries.open(paper)
    try:
        assert len(found.levels) == 2 * 3 * 12 * 21
        assert set(found.accuracy["approach"]) == {"moving-roughness", "moving-roughness-uncorrelated"}
        assert found.runtime["cpu_s"].max() == 7.5
        assert found.sql("SELECT count(*) AS n FROM cases")["n"].tolist() == [2]
        with pytest.raises(ResultsError):
            found.sql("DROP TABLE cases")
    finally:
        found.close()


def test_a_manifest_without_history_is_enough(study):
    directory = study.write(lines=20)
    shutil.rmtree(directory / records.RECORDS / "runs")
    assert "run-1" in made(directory)
