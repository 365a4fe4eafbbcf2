"""A file of an earlier form becomes one of this form, in one step, after a copy; with either DuckDB."""

import os
import subprocess
import sys
from pathlib import Path

import duckdb
import pytest
from click.testing import CliRunner

from queries import cli
from queries.database import DATABASE, ResultsError, connect, ingest, schema
from queries.database.connection import attach
from tests.queries.database.test_ingest import rows

ROOT = Path(__file__).parents[3]


def earlier(path):
    """Make a file of the first form with a run, a case and a band in it."""
    path.unlink(missing_ok=True)
    with schema.open_for_writing(path) as connection:
        connection.execute(schema.migrations()[0][2])
        connection.execute("INSERT INTO schema_version VALUES (1, 'tables', 'a form of then')")
        connection.execute("INSERT INTO snapshot VALUES ('then', 'then')")
        connection.execute("INSERT INTO runs (run_id, sequence, reference) VALUES ('run-0', 1, 'full')")
        connection.execute("INSERT INTO run_cases VALUES ('run-0', 'case')")
        connection.execute("INSERT INTO cases (case_id, soil, speed_kmh) VALUES ('case', 'clay', 90)")
        connection.execute("INSERT INTO case_units VALUES ('run-0', 'case', 'full', 'unit', 'case')")
        connection.execute(
            "INSERT INTO bands (case_id, approach, quantity, receiver, averaging, band_hz, mean_square, "
            "unit_id) "
            "VALUES ('case', 'full', 'velocity', 'rail', 'line', 10, 1e-10, 'unit')"
        )
        connection.execute("CREATE VIEW levels AS SELECT 'a view of then' AS said")
        connection.execute("CREATE MACRO decibel(x) AS 0")
    return path


def upgraded(path):
    with schema.open_for_writing(path) as connection:
        schema.upgrade(connection)
    return attach(path)


def test_rows_of_an_earlier_form_are_kept_and_views_are_those_of_now(tmp_path):
    with upgraded(earlier(tmp_path / "old.duckdb")) as connection:
        assert connection.execute("SELECT version FROM schema_version").fetchall() == [(1,), (2,), (3,), (4,)]
        assert connection.execute("FROM sources").fetchall() == [(1, ".", None)]
        assert connection.execute("SELECT run_id, soil, level_db FROM levels").fetchall() == [
            ("run-0", "clay", pytest.approx(80.0))
        ]
        assert connection.execute("SELECT planned_tasks, measured_cpu_s FROM runs").fetchall() == [
            (None, None)
        ]


def test_an_upgraded_file_has_the_form_of_a_new_one(tmp_path):
    form = (
        "SELECT table_name, column_name, data_type, comment FROM duckdb_columns() WHERE NOT internal ORDER "
        "BY ALL"
    )
    with upgraded(earlier(tmp_path / "old.duckdb")) as connection:
        old = connection.execute(form).fetchall()
    with schema.open_for_writing(tmp_path / "new.duckdb") as connection:
        schema.upgrade(connection)
        assert connection.execute(form).fetchall() == old


def test_a_migration_that_fails_changes_nothing(tmp_path, monkeypatch):
    path = earlier(tmp_path / "old.duckdb")
    first, second, *_ = schema.migrations()
    broken = (2, "broken", "CREATE TABLE half (i INTEGER); DELETE FROM bands; SELECT error('broken')")
    monkeypatch.setattr(schema, "migrations", lambda: [first, broken])
    with schema.open_for_writing(path) as connection, pytest.raises(duckdb.Error, match="broken"):
        schema.upgrade(connection)
    monkeypatch.undo()
    assert second[0] == 2
    with attach(path, any_form=True) as connection:
        assert schema.version(connection) == 1
        assert connection.execute("SELECT count(*) FROM bands").fetchone() == (1,)
        assert connection.execute("SELECT said FROM levels").fetchall() == [("a view of then",)]


def test_ingest_keeps_a_copy_of_an_earlier_file_and_brings_it_up_to_date(study):
    directory = study.write(lines=10)
    ingest(directory)
    expected = rows(directory)
    before = earlier(directory / DATABASE).read_bytes()
    result = CliRunner().invoke(cli.sql, [str(directory), "FROM cases"])
    assert result.exit_code == 2
    assert "form 1 of 4" in result.stderr
    assert "railvib ingest" in result.stderr
    ingested = ingest(directory)
    assert ingested.backup == directory / "results.form-1.duckdb"
    assert ingested.backup.read_bytes() == before
    found = rows(directory)
    assert {name for name in expected if found[name] != expected[name]} <= {"cases", "bands", "snapshot"}
    assert set(expected["levels"]) == set(found["levels"])


def test_a_file_of_a_newer_form_is_refused_and_left_alone(study):
    directory = study.write(lines=10)
    path = directory.parent / "all.duckdb"
    ingest(directory, file=path)
    with duckdb.connect(str(path)) as connection:
        connection.execute("INSERT INTO schema_version VALUES (99, 'of the future', NULL)")
    before = path.read_bytes()
    with pytest.raises(ResultsError, match="form 99, written by a newer railvib"):
        ingest(directory, file=path)
    with pytest.raises(ResultsError, match="form 99, written by a newer railvib"):
        connect(path)
    assert path.read_bytes() == before


def test_a_file_that_is_no_database_of_results_is_refused_and_left_alone(study):
    directory = study.write(lines=10)
    other = directory.parent / "other.duckdb"
    with duckdb.connect(str(other)) as connection:
        connection.execute("CREATE TABLE mine (i INTEGER)")
    text = directory.parent / "notes.txt"
    text.write_text("mine" * 5000)
    for path in (other, text):
        before = path.read_bytes()
        with pytest.raises(ResultsError, match=str(path.name)):
            ingest(directory, file=path)
        with pytest.raises(ResultsError, match=str(path.name)):
            connect(path)
        assert path.read_bytes() == before


# The locked DuckDB runs all tests; this one runs those of the database with the other major version.
OTHER = {"1": "duckdb==2.*", "2": "duckdb==1.5.*"}[duckdb.__version__[0]]
CORE = (
    "test_ingest.py::test_every_case_band_and_line_arrives",
    "test_ingest.py::test_spectra_arrive_as_they_are_stored",
    "test_ingest.py::test_rebuilding_gives_the_same_rows",
    "test_migrations.py",
    "test_sources.py",
    "../answers/test_sql.py",
    "test_views.py",
)


@pytest.mark.slow
def test_the_other_major_duckdb_passes_the_tests_of_the_database_and_reads_its_files(paper, tmp_path):
    if os.environ.get("RAILVIB_OTHER_DUCKDB"):
        assert OTHER.partition("==")[2][0] != os.environ["RAILVIB_OTHER_DUCKDB"]
        return  # this is the other one
    target = tmp_path / "other"
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
        + ["--target", str(target), OTHER],
        check=True,
        capture_output=True,
    )
    environment = {
        **os.environ,
        "PYTHONPATH": f"{target}{os.pathsep}{ROOT}",
        "RAILVIB_OTHER_DUCKDB": OTHER.partition("==")[2][0],
    }
    read = (
        "import sys, duckdb; from queries.database import connect; "
        "print(duckdb.__version__); "
        "print(connect(sys.argv[1]).execute('SELECT count(*), sum(level_db) FROM "
        "levels').fetchone())"
    )
    found = subprocess.run(
        [sys.executable, "-c", read, str(paper)], env=environment, check=True, capture_output=True, text=True
    ).stdout.splitlines()
    assert found[0][0] == environment["RAILVIB_OTHER_DUCKDB"]
    with connect(paper) as connection:
        mine = connection.execute("SELECT count(*), sum(level_db) FROM levels").fetchone()
    assert str(mine[0]) in found[1]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x"] + [str(Path(__file__).parent / name) for name in CORE],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:]
    written = tmp_path / "written" / "run"
    write = (
        "import sys; from pathlib import Path; from queries.database.ingest import ingest; "
        "from benchmarks.runs.invented import Study; ingest(Study(Path(sys.argv[1])).write(lines=10))"
    )
    subprocess.run([sys.executable, "-c", write, str(written)], env=environment, cwd=ROOT, check=True)
    with connect(written) as connection:
        assert connection.execute("SELECT count(*) FROM accuracy").fetchone() == (2 * 2 * 12 * 21,)
