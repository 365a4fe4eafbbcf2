"""`railvib sql` answers questions and can do nothing else."""

import csv
import io
import resource

import duckdb
import pytest
from click.testing import CliRunner

from queries import cli
from queries.answers.sql import query
from queries.database import DATABASE, ResultsError


def ask(directory, *arguments):
    return CliRunner().invoke(cli.sql, [str(directory), *map(str, arguments)])


def test_a_question_is_answered_with_a_table(paper):
    done = ask(paper, "SELECT soil, speed_kmh FROM cases ORDER BY soil")
    assert done.exit_code == 0
    assert [line.split() for line in done.output.splitlines() if "150" in line] == [
        ["greby", "150.0"],
        ["horstwalde", "150.0"],
    ]


@pytest.mark.parametrize(
    "statement",
    [
        "FROM cases",
        "WITH a AS (SELECT 1 AS x) SELECT x FROM a",
        "VALUES (1)",
        "DESCRIBE bands",
        "SHOW TABLES",
        "SUMMARIZE cases",
        "EXPLAIN FROM levels",
        "FROM compare('moving-roughness', 'full') LIMIT 1",
        "SELECT versions->>'numpy' FROM runs",
        "SELECT 1;",
        "FROM duckdb_columns() LIMIT 1",
        "FROM pragma_version()",
        "FROM range(3)",
        "SELECT unnest([1, 2])",
        "EXPLAIN ANALYZE FROM cases",
        "FROM (PIVOT cases ON soil IN ('greby') USING count(*))",
        "SELECT '; enable_logging() --' AS text",
    ],
)
def test_statements_that_read_are_allowed(paper, statement):
    done = ask(paper, statement)
    assert (done.exit_code, done.stderr) == (0, "")


WRITING = [
    "CREATE TABLE t (i INTEGER)",
    "CREATE TEMP TABLE t (i INTEGER)",
    "INSERT INTO cases VALUES (NULL)",
    "UPDATE bands SET mean_square = 0",
    "DELETE FROM bands",
    "DROP TABLE bands",
    "DROP VIEW levels",
    "ALTER TABLE bands ADD COLUMN x INTEGER",
    "COPY bands TO 'out.csv'",
    "COPY bands FROM 'in.csv'",
    "EXPORT DATABASE 'out'",
    "ATTACH 'other.duckdb' AS other",
    "ATTACH ':memory:' AS other",
    "DETACH results",
    "USE memory",
    "INSTALL httpfs",
    "LOAD httpfs",
    "SET memory_limit = '1GB'",
    "RESET memory_limit",
    "PRAGMA threads = 8",
    "CALL pragma_version()",
    "CHECKPOINT",
    "BEGIN",
    "PREPARE p AS SELECT 1",
    "EXECUTE p",
    "SET VARIABLE a = 1",
    "SELECT 1; DROP TABLE bands",
    "EXPLAIN ANALYZE DELETE FROM bands",
    "EXPLAIN ANALYZE COPY bands TO 'out.csv'",
    "FROM read_csv('/etc/hostname')",
    "FROM read_text('/etc/hostname')",
    "FROM read_parquet('x.parquet')",
    "FROM read_json('x.json')",
    "FROM '/etc/hostname'",
    "FROM glob('/etc/*')",
    "FROM parquet_metadata('x.parquet')",
    "FROM sniff_csv('/etc/hostname')",
    "FROM a_local_variable",
    "FROM enable_logging(storage = 'file', storage_path = 'log.csv')",
    "CALL enable_logging()",
    """FROM "enable_logging"/* /* */ */(level := 'debug')""",
    "SELECT (SELECT count(*) FROM enable_logging())",
    "EXPLAIN ANALYZE FROM main.enable_profiling()",
    "FROM force_checkpoint()",
    "FROM json_execute_serialized_sql('{}')",
    "SELECT * FROM read_blob('/etc/hostname')",
    "SELECT content FROM read_text('run.json')",
    "FROM sqlite_scan('x.db', 'x')",
    "FROM read_duckdb('x.duckdb')",
    "FROM duckdb_secrets() UNION ALL FROM read_csv('/etc/hostname')",
    "SELECT getenv('HOME')",
    "WITH a AS (FROM read_csv('/etc/hostname')) FROM a",
    "FROM query('DROP TABLE bands')",
    "FROM query('FROM read_csv(''/etc/hostname'')')",
    "CREATE MACRO m() AS 1",
    "CREATE SECRET s (TYPE s3, KEY_ID 'a', SECRET 'b')",
    "COMMENT ON TABLE bands IS 'mine'",
    "MERGE INTO bands USING cases ON true WHEN MATCHED THEN DELETE",
    "TRUNCATE bands",
    "VACUUM",
    "IMPORT DATABASE 'out'",
    "SELECT 1 INTO OUTFILE 'x'",
    "",
    "SELEC 1",
    "SELECT no_such_column FROM cases",
    "FROM no_such_table",
]


@pytest.mark.parametrize("statement", WRITING)
def test_everything_else_is_refused_in_one_line(paper, statement, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    a_local_variable = {"x": [1]}  # noqa: F841  (DuckDB reads Python variables unless told not to)
    before = (paper / DATABASE).read_bytes()
    done = ask(paper, statement)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) == 1
    assert done.stderr.startswith("Error: ")
    assert list(tmp_path.iterdir()) == []
    assert (paper / DATABASE).read_bytes() == before


@pytest.mark.parametrize(
    "statement", [text for text in WRITING if text.startswith(("COPY", "ATTACH 'o", "UPD", "SET m"))]
)
def test_the_connection_refuses_what_the_check_of_statements_would_let_pass(results, statement):
    with pytest.raises(duckdb.Error):
        results.execute(statement)


def test_the_message_says_what_kind_of_statement_was_refused(results):
    with pytest.raises(ResultsError, match="only statements that read are allowed.*DROP"):
        query(results, "DROP TABLE bands")


def test_the_message_of_an_unknown_column_proposes_one(results):
    with pytest.raises(ResultsError, match="speed_kmh"):
        query(results, "SELECT speed_km FROM cases")


def test_placeholders_take_names_as_data(results):
    found = query(
        results, "SELECT count(*) FROM cases WHERE soil = ?", ["x'; DROP TABLE cases; --"]
    ).fetchall()
    assert found == [(0,)]


def test_csv_holds_every_row(paper):
    done = ask(paper, "SELECT receiver, offset_m, band_hz FROM bands", "--format", "csv")
    found = list(csv.reader(io.StringIO(done.output)))
    assert found[0] == ["receiver", "offset_m", "band_hz"]
    assert len(found) == 1 + 2 * 3 * 12 * 21
    assert ["rail", "", "1.0"] in found


def test_csv_goes_to_a_file(paper, tmp_path):
    done = ask(paper, "SELECT 1 AS a", "--format", "csv", "--output", tmp_path / "a.csv")
    assert (done.exit_code, done.output) == (0, "")
    assert (tmp_path / "a.csv").read_text() == "a\n1\n"


def test_parquet_is_read_back(paper, tmp_path):
    output = tmp_path / "it's.parquet"
    done = ask(paper, "SELECT soil, band_hz, level_db FROM levels", "--format", "parquet", "--output", output)
    assert done.exit_code == 0
    with duckdb.connect(":memory:") as reader:
        found = reader.execute(
            "SELECT count(*), count(level_db) FROM read_parquet(?)", [str(output)]
        ).fetchall()
    assert found == [(2 * 3 * 12 * 21, 2 * 3 * 12 * 21)]


def test_parquet_needs_a_file(paper):
    done = ask(paper, "SELECT 1", "--format", "parquet")
    assert done.exit_code == 2
    assert "--output" in done.stderr


def test_a_file_that_cannot_be_written_is_said(paper, tmp_path):
    done = ask(paper, "SELECT 1", "--format", "csv", "--output", tmp_path / "no" / "such" / "folder.csv")
    assert done.exit_code == 2
    assert "cannot be written" in done.stderr


def test_a_long_table_says_that_there_is_more(paper):
    done = ask(paper, "FROM range(1500)")
    assert "The first 1000 rows" in done.output
    assert "999" in done.output
    assert "1499" not in done.output


def test_a_wide_table_is_not_cut_off_in_a_pipe(paper):
    done = ask(paper, "SELECT repeat('a', 300) AS wide, 'end' AS last")
    assert "a" * 300 in done.output
    assert "end" in done.output


def test_a_name_with_markup_or_escapes_is_shown_as_it_is(paper):
    done = ask(paper, "SELECT '[red]x[/red]' AS markup, 'a' || chr(27) || '[2J' AS escape")
    assert "[red]x[/red]" in done.output
    assert "\x1b" not in done.output


def test_a_directory_without_results_says_how_to_make_them(study):
    directory = study.write()
    done = ask(directory, "SELECT 1")
    assert done.exit_code == 2
    assert "railvib ingest" in done.stderr


def test_a_directory_that_is_no_run_is_refused(tmp_path):
    done = ask(tmp_path, "SELECT 1")
    assert done.exit_code == 2
    assert "run.json" in done.stderr


LIMITS = {
    "time": ("SELECT count(*) FROM range(10000000) a, range(10000000) b", ["--time-limit", "0.5"], "0.5 s"),
    "time of a recursion": (
        "WITH RECURSIVE a(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM a) SELECT max(n) FROM a",
        ["--time-limit", "0.5"],
        "0.5 s",
    ),
    "memory": ("SELECT list(range) FROM range(1000000000)", ["--memory-limit", "100"], "100 MB of memory"),
    "memory of a text": ("SELECT repeat('x', 3000000000)", ["--memory-limit", "100"], "100 MB of memory"),
    "memory of many texts": (
        "SELECT repeat('x', 1000000) FROM range(1000000)",
        ["--memory-limit", "200", "--format", "csv", "--print-limit", "1e6"],
        "200 MB of memory",
    ),
    "print": ("SELECT repeat('x', 2000000)", ["--print-limit", "1"], "longer than 1 MB; --print-limit"),
    "print of rows": ("FROM range(1000000)", ["--print-limit", "1", "--format", "csv"], "longer than 1 MB"),
}


@pytest.mark.parametrize("limit", LIMITS)
def test_a_query_that_reaches_a_limit_ends_with_one_line(paper, limit):
    statement, options, said = LIMITS[limit]
    before = resource.getrlimit(resource.RLIMIT_DATA)
    done = ask(paper, statement, *options)
    assert done.exit_code == 2, done.output[:1000]
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert len(done.stdout) <= 1_000_000
    assert resource.getrlimit(resource.RLIMIT_DATA) == before


def test_a_long_answer_goes_to_a_file(paper, tmp_path):
    output = tmp_path / "long.csv"
    done = ask(paper, "FROM range(300000)", "--print-limit", "1", "--format", "csv", "--output", output)
    assert done.exit_code == 0, done.output
    assert len(output.read_text().splitlines()) == 300_001


@pytest.mark.parametrize("option", ["--time-limit", "--memory-limit", "--print-limit"])
@pytest.mark.parametrize("value", ["0", "-1", "much"])
def test_a_limit_is_a_positive_number(paper, option, value):
    assert ask(paper, "SELECT 1", option, value).exit_code == 2
