"""Commands in places where they cannot work, and on disks that are full: one line, and nothing is lost."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import duckdb
import pytest
from click.testing import CliRunner

from benchmarks.runs.invented import Study
from queries import cli
from queries.database import DATABASE, connect, ingest
from queries.database.replacement import row_counts

LATER = "2026-03-02T08:00:00+00:00"
UNTEXT = os.fsdecode(b"not \xff text")


def below_a_file(folder):
    (folder / "file").touch()
    return folder / "file" / "below"


def through_a_loop(folder):
    (folder / "loop").symlink_to(folder / "loop")
    return folder / "loop" / "below"


def through_a_dangling_link(folder):
    (folder / "dangling").symlink_to(folder / "nowhere")
    return folder / "dangling" / "below" / "further"


WRITTEN = {
    "below a file": below_a_file,
    "through a loop of links": through_a_loop,
    "with a name of 300 letters": lambda folder: folder / ("x" * 300),
    "in a read-only file system": lambda _: Path("/sys/kernel/nowhere"),
    "in a process's folder": lambda _: Path("/proc/self/nowhere"),
}
COMMANDS = {
    "sql": lambda run, place: (cli.sql, [run, "SELECT 1", "--format", "csv", "--output", place]),
    "parquet": lambda run, place: (cli.sql, [run, "SELECT 1", "--format", "parquet", "--output", place]),
    "queries": lambda run, place: (cli.queries, ["error-against-distance", run, "--output", place]),
    "report": lambda run, place: (cli.report, [run, "--output", place]),
    "figures": lambda run, place: (cli.figures, [run, "--output", place]),
    "export": lambda run, place: (cli.export, [run, place]),
    "ingest": lambda run, place: (cli.ingest, [run, "--database", place]),
}


def check_refused(command, arguments):
    """Check that a command ends with exit code 2 and one line that names no Python."""
    result = CliRunner().invoke(command, list(map(str, arguments)))
    assert result.exit_code == 2, (result.output, result.exception)
    assert len(result.stderr.strip().splitlines()) == 1, result.stderr
    assert result.stderr.startswith("Error: ")
    assert "Traceback" not in result.output
    return result.stderr


@pytest.fixture(autouse=True)
def _one_figure(monkeypatch):
    from queries.figures import catalogue

    drawings = catalogue.drawings
    monkeypatch.setattr(catalogue, "drawings", lambda *given, **named: drawings(*given, **named)[:1])


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("place", WRITTEN)
def test_a_place_that_cannot_be_written_is_refused_in_one_line(paper, tmp_path, command, place):
    target = WRITTEN[place](tmp_path)
    before = sorted(tmp_path.rglob("*"))
    check_refused(*COMMANDS[command](paper, target))
    assert sorted(tmp_path.rglob("*")) == before


READING = {
    "sql": lambda run: (cli.sql, [run, "SELECT 1"]),
    "queries": lambda run: (cli.queries, ["error-against-distance", run]),
    "compare": lambda run: (cli.compare, [run]),
    "report": lambda run: (cli.report, [run]),
    "figures": lambda run: (cli.figures, [run]),
    "export": lambda run: (cli.export, [run, f"{run}-exported"]),
    "ingest": lambda run: (cli.ingest, [run]),
}


def a_question_mark(run):
    return run.rename(run.parent / "what?")


def a_backslash(run):
    return run.rename(run.parent / "back\\slash")


def bytes_that_are_no_text(run):
    return run.rename(run.parent / UNTEXT)


def a_folder_in_place_of_the_database(run):
    (run / DATABASE).unlink(missing_ok=True)
    (run / DATABASE).mkdir()
    return run


REFUSED = (a_question_mark, a_backslash, bytes_that_are_no_text, a_folder_in_place_of_the_database)


@pytest.mark.parametrize("command", READING)
@pytest.mark.parametrize("place", REFUSED)
def test_a_run_that_duckdb_cannot_open_is_refused_in_one_line(study, command, place):
    run = place(study.write(soils=("clay",), lines=10))
    check_refused(*READING[command](run))
    assert not list(run.parent.rglob(f"{DATABASE}.*"))


@pytest.mark.parametrize(
    "name", ["*x[y]{z}", "s3:x", "http:", "~", "-x", "a;b --", 'it\'s "quoted"', "ünïcode"]
)
def test_names_that_mean_something_to_duckdb_are_names_of_files(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    directory = Study(Path(name)).write(soils=("clay",), lines=10)
    for command in ("ingest", "report", "figures", "export"):
        command, arguments = READING[command](directory)
        result = CliRunner().invoke(command, ["--", *map(str, arguments)])
        assert result.exit_code == 0, result.output
    with connect(directory) as connection:
        assert connection.execute("SELECT count(*) FROM cases").fetchone() == (1,)
    assert (directory / DATABASE).is_file()
    assert {path.name for path in tmp_path.iterdir()} == {name, f"{name}-exported"}


def test_a_file_that_is_no_database_is_never_replaced(paper, tmp_path):
    for content in (b"mine" * 5000, b""):
        path = tmp_path / "notes"
        path.write_bytes(content)
        for more in ([], ["--rebuild"]):
            check_refused(cli.ingest, [paper, "--database", path, *more])
            assert path.read_bytes() == content


@pytest.fixture
def kept(tmp_path):
    """Return a database with the rows of a directory that is gone and of one that has grown since."""
    gone, there = (Study(tmp_path / name) for name in ("gone", "there"))
    path = tmp_path / "all.duckdb"
    gone.write(soils=("clay",), lines=2000)
    ingest([gone.directory, there.write(lines=2000, run_id="run-2", started=LATER)], file=path)
    shutil.rmtree(gone.directory)
    there.write(lines=2000, run_id="run-3", started="2026-03-03T08:00:00+00:00", speeds=(200.0, 250.0))
    return path


INGEST = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from queries.cli import ingest
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
ingest([sys.argv[3], "--database", sys.argv[2]])
"""


def contents(path):
    with connect(path) as connection:
        levels = connection.execute("SELECT count(*) FROM run_levels WHERE run_id = 'run-1'").fetchone()
        return row_counts(connection), levels


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.9, 0.99, 0.999, 1.5])
def test_a_full_disk_leaves_what_a_database_held_before(kept, share):
    before = contents(kept)
    trial = shutil.copyfile(kept, kept.with_name("trial.duckdb"))
    ingest(kept.parent / "there", file=trial)
    whole, size = contents(trial), trial.stat().st_size
    trial.unlink()
    done = subprocess.run(
        [sys.executable, "-c", INGEST, str(int(share * size)), str(kept), str(kept.parent / "there")],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode == 0:
        assert "written" in done.stdout
        assert contents(kept) == whole
    else:
        assert done.returncode == 2
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr
        assert "File too large" in done.stderr
        assert "rollback" not in done.stderr
        assert "written" not in done.stdout.replace("cannot be written", "")
        assert contents(kept) == before
    assert (share >= 1.0) == (done.returncode == 0)
    assert {path.name for path in kept.parent.iterdir()} == {"all.duckdb", "there"}


def test_too_little_space_is_refused_before_anything_is_written(kept, monkeypatch):
    before = contents(kept)
    usage = shutil.disk_usage(kept.parent)._replace(free=kept.stat().st_size)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    monkeypatch.setattr(shutil, "copyfile", lambda *_: pytest.fail("began to write"))
    assert "MB are free" in check_refused(cli.ingest, [kept.parent / "there", "--database", kept])
    assert contents(kept) == before


@pytest.mark.parametrize("loss", ["a row", "the file's end"])
def test_a_file_that_lost_something_does_not_take_the_place(kept, monkeypatch, loss):
    from queries.database import replacement

    before = contents(kept)
    put_in_place = replacement.put_in_place

    def lossy(partial, *arguments):
        if loss == "a row":
            with duckdb.connect(str(partial)) as connection:
                connection.execute("DELETE FROM units WHERE rowid = 0")
        else:
            os.truncate(partial, partial.stat().st_size // 2)
        put_in_place(partial, *arguments)

    monkeypatch.setattr(replacement, "put_in_place", lossy)
    check_refused(cli.ingest, [kept.parent / "there", "--database", kept])
    assert contents(kept) == before
    assert {path.name for path in kept.parent.iterdir()} == {"all.duckdb", "there"}


def test_publishing_that_fails_says_what_to_do(study, capsys):
    import click

    import queries

    directory = study.write(soils=("clay",), lines=10)
    (directory / DATABASE).mkdir()
    with queries.after_run(directory) as publisher, pytest.raises(click.ClickException) as refusal:
        publisher.publish()
    assert refusal.value.exit_code == 2
    assert "is a folder where a database file should be" in refusal.value.message
    assert f"railvib report {directory}" in refusal.value.message
