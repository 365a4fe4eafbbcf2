"""The report is one file, says what the database says, and takes names as text."""

import base64
import html.parser
import json
import multiprocessing
import re
import shutil

import duckdb
import numpy as np
import pytest
from click.testing import CliRunner

import queries
from queries import cli
from queries.database import DATABASE, ResultsError, connect
from queries.figures import catalogue
from queries.report import spectra as narrow_band
from sweep.storage import records


@pytest.fixture(autouse=True)
def _few_figures(monkeypatch):
    """Draw the first figure only, for drawing takes time."""
    drawings = catalogue.drawings
    monkeypatch.setattr(catalogue, "drawings", lambda *given, **named: drawings(*given, **named)[:1])


class Page(html.parser.HTMLParser):
    """Collects tags with their attributes, all text, and the data of the figures."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words, self.open, self.scripts = [], [], [], []
        self.feed(text)
        self.data = json.loads(self.scripts[0])

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in ("meta", "link", "input", "line"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.scripts.append(data)
        elif self.open and self.open[-1] != "style":
            self.words.append(data)

    def level(self, case, approach, receiver, band):
        """Return the dynamic level of a case that the figures show, dB."""
        data = self.data
        sizes = [len(data[name]) for name in ("cases", "approaches", "contributions", "receivers", "bands")]
        packed = np.frombuffer(base64.b64decode(data["levels"]), dtype="<i2").reshape(sizes)
        names = [approach["name"] for approach in data["approaches"]]
        receivers = [receiver["label"] for receiver in data["receivers"]]
        return packed[case, names.index(approach), 0, receivers.index(receiver), band] / 100


def made(directory):
    result = CliRunner().invoke(cli.report, [str(directory)])
    assert result.exit_code == 0, result.output
    assert result.output.strip() == str(directory / "report.html")
    return (directory / "report.html").read_text(encoding="utf-8")


def test_the_report_stands_alone(study):
    text = made(study.write(lines=20))
    page = Page(text)
    assert page.open == []
    links = [
        value for _, attributes in page.tags for name, value in attributes.items() if name in ("src", "href")
    ]
    assert links == ["data:,", "#figures"]
    assert {tag for tag, _ in page.tags} & {"iframe", "object", "img"} == set()
    assert "default-src 'none'" in text
    assert text.count("plotly.js v") == 1


def test_the_figures_have_every_level_of_the_database(study):
    directory = study.write(lines=20)
    page = Page(made(directory))
    with connect(directory) as connection:
        rows = connection.execute(
            "SELECT soil, approach, round(log10(band_hz) * 10)::INTEGER, level_db FROM levels "
            "WHERE receiver = 'ground' AND offset_m = 8 AND contribution = 'dynamic'"
        ).fetchall()
    assert len(rows) == 2 * 3 * 21
    for soil, approach, band, level in rows:
        case = ["horstwalde", "greby"].index(soil)
        assert page.level(case, approach, "ground at 8 m", band) == pytest.approx(level, abs=0.0051)


def test_the_report_has_summary_tables_and_provenance(study):
    words = " ".join(Page(made(study.write(lines=20))).words)
    for expected in (
        "Moving roughness is 1.0 dB from the full model on average",
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
    with duckdb.connect(str(directory / DATABASE)) as connection:
        connection.execute(
            "UPDATE bands SET mean_square = mean_square * 1e-5 WHERE approach = 'moving-roughness' "
            "AND receiver = 'rail' AND contribution = 'dynamic' AND band_hz > 99"
        )
    text = made(directory)
    assert "-49.0" in text
    page = Page(text)
    assert page.level(0, "moving-roughness", "rail", 20) == pytest.approx(60 - 10 - 10 + 1 - 50, abs=0.0051)


def test_names_are_text(study):
    soil, name = "<script>alert(1)</script>", '"><img src=x onerror=alert(1)>'
    page = Page(made(study.write(soils=(soil, "'; DROP TABLE cases; --"), name=name, lines=20)))
    assert [attributes for tag, attributes in page.tags if tag == "img"] == []
    assert len(page.scripts) == 6
    assert page.data["axes"]["soil"] == [soil, "'; DROP TABLE cases; --"]
    assert not any("onerror" in attributes for _, attributes in page.tags)
    words = " ".join(page.words)
    assert soil in words
    assert name in words


@pytest.mark.parametrize(("title", "heading"), [(None, "paper"), ("Line 4 – Nord", "Line 4 – Nord")])
def test_the_title_of_a_study_heads_its_report(study, title, heading):
    text = made(study.write(title=title, lines=20))
    assert f"<h1>{heading}</h1>" in text
    assert f"<title>Ground vibration: {heading}</title>" in text


def test_a_failure_is_said_in_the_report(study):
    words = " ".join(Page(made(study.write(lost=("full",), lines=20))).words)
    assert "full lacks results in 2 of 2 cases (ArithmeticError: no <b>solution</b>)" in words


def publish(directory):
    with queries.after_run(directory) as publisher:
        publisher.publish()


def test_after_a_run_everything_is_there_and_shown(study, capsys):
    directory = study.write(lines=20)
    publish(directory)
    shown = capsys.readouterr().out
    assert "Error of moving-roughness against full" in shown
    for place in ("results.duckdb", "report.html", "figures", "transfer_functions.zarr"):
        assert (directory / place).exists()
        assert re.search(rf"{re.escape(str(directory / place))}$", shown, re.MULTILINE)


def test_after_a_run_that_added_nothing_figures_stay_and_the_report_names_the_run(study, capsys):
    directory = study.write(lines=20)
    publish(directory)
    before = {path: path.stat().st_mtime_ns for path in (directory / "figures").iterdir()}
    study.write(lines=20, run_id="run-2", started="2026-03-02T08:00:00+00:00")
    publish(directory)
    assert {path: path.stat().st_mtime_ns for path in (directory / "figures").iterdir()} == before
    report = directory / "report.html"
    assert "run-2" in report.read_text(encoding="utf-8")
    written = report.stat().st_mtime_ns
    publish(directory)
    assert report.stat().st_mtime_ns == written
    assert capsys.readouterr().out.count("Cost per case") == 3


def test_after_a_run_that_changed_results_figures_are_drawn_anew(study):
    directory = study.write(lines=20)
    publish(directory)
    before = (directory / "figures" / "figure-03-unevenness.png").stat().st_mtime_ns
    study.write(lines=20, run_id="run-2", started="2026-03-02T08:00:00+00:00", speeds=(150.0, 200.0))
    publish(directory)
    assert (directory / "figures" / "figure-03-unevenness.png").stat().st_mtime_ns > before


def test_figures_that_were_removed_come_back(study):
    directory = study.write(lines=20)
    publish(directory)
    shutil.rmtree(directory / "figures")
    (directory / "report.html").unlink()
    publish(directory)
    assert len(list((directory / "figures").glob("*.png"))) == 1


def test_publishing_that_is_given_notice_leaves_the_same_and_no_process(study, monkeypatch):
    monkeypatch.setattr("queries.figures.WORKERS", 2)
    directory = study.write(lines=20)
    publish(directory)
    figure = directory / "figures" / "figure-03-unevenness.png"
    before = figure.read_bytes()
    shutil.rmtree(directory / "figures")
    for name in ("report.html", "results.duckdb"):
        (directory / name).unlink()
    with queries.after_run(directory) as publisher:
        publisher.get_ready()
        publisher.publish()
    assert figure.read_bytes() == before
    assert (directory / "report.html").exists()
    assert not list(directory.glob("results.duckdb.*"))
    (directory / "results.duckdb").unlink()
    with queries.after_run(directory) as publisher:
        publisher.get_ready()  # and then the run is interrupted
        processes = multiprocessing.active_children()
    assert not list(directory.glob("results.duckdb.*"))
    assert len(processes) == 1  # those that draw are forked from it
    assert all(process.exitcode is not None for process in processes)
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("command", [cli.ingest, cli.compare, cli.report])
def test_a_directory_that_is_no_run_is_refused_in_one_line(command, tmp_path):
    for directory in (tmp_path, tmp_path / "nowhere"):
        result = CliRunner().invoke(command, [str(directory)])
        assert result.exit_code == 2
        assert result.stdout == ""
        assert len(result.stderr.strip().splitlines()) == 1
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


def test_a_case_without_reference_has_levels_and_no_error(study):
    page = Page(made(study.write(lost=("full",), lines=20)))
    words = " ".join(page.words)
    assert "Moving roughness cannot be compared with the full model: no case has results of both." in words
    assert page.level(0, "moving-roughness", "rail", 0) == pytest.approx(60 - 10 - 0.1 + 1, abs=0.0051)
    assert page.level(0, "full", "rail", 0) == -327.68


@pytest.mark.parametrize(("share", "bins"), [(10_000_000, 0), (50_000, 347)])
def test_thinned_lines_keep_the_extremes_and_it_is_said(study, monkeypatch, share, bins):
    monkeypatch.setattr(narrow_band, "LINES_BYTES", share)
    monkeypatch.setattr(narrow_band, "FEW_BINS", 200)
    directory = study.write(soils=("clay",), lines=2000)
    page = Page(made(directory))
    lines = page.data["lines"]
    assert (lines["bins"], lines["lines"]) == (bins, 2000)
    assert ("All 2,000 lines" in " ".join(page.words)) == (bins == 0)
    (spectra,) = lines["spectra"]
    packed = np.frombuffer(base64.b64decode(spectra["levels"]), dtype="<i2").reshape(
        len(spectra["places"]), -1
    )
    rail = [receiver["label"] for receiver in page.data["receivers"]].index("rail")
    full = [approach["name"] for approach in page.data["approaches"]].index("full")
    places = list(zip(spectra["places"], spectra["receivers"], strict=True))
    own = packed[places.index((full * 3, rail))]
    own = own[own > -32768] / 100
    with connect(directory) as connection:
        lowest, highest, count = connection.execute(
            "SELECT decibel(min(value) * 1e18), decibel(max(value) * 1e18), count(*) FROM psd "
            "WHERE approach = 'full' AND receiver = 'rail' AND contribution = 'dynamic'"
        ).fetchone()
    assert [own.min(), own.max()] == pytest.approx([lowest, highest], abs=0.0051)
    assert own.size <= (2 * bins or count)


def test_a_page_that_would_be_too_large_shows_fewer_cases(study, monkeypatch):
    monkeypatch.setattr(narrow_band, "LINES_BYTES", 9000)
    directory = study.write(soils=("clay",), speeds=(100.0, 150.0, 200.0), lines=300)
    page = Page(made(directory))
    assert page.data["lines"]["cases"] == len(page.data["lines"]["spectra"]) == 1
    assert "1 of 3 cases have one" in " ".join(page.words)
