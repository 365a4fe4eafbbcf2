"""Levels of passages, from a run of the small study to rows and answers."""

import pytest
from click.testing import CliRunner

from queries import cli
from queries.database import connect
from tests.sweep.small import STUDY, invoke

LEVELS = """
[levels]
metrics = ["kb-f-max", "ppv"]
quantiles = [0.5, 0.95]
passages = 16
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    directory = tmp_path_factory.mktemp("levels")
    (directory / "small.toml").write_text(STUDY + LEVELS)
    out = directory / "out"
    result = invoke("run", directory / "small.toml", "--out", out, "--workers", 1)
    assert result.exit_code == 0, result.output
    return out


def test_rows(run):
    with connect(run) as connection:
        rows = connection.execute(
            "SELECT approach, receiver, offset_m, component, metric, statistic, value, unit "
            "FROM passage_levels"
        ).fetchall()
    # Two approaches, the rail and 8 m; mean and two quantiles of both metrics, and what is expected of KB.
    assert len(rows) == 2 * 2 * 7
    assert {row[:4] for row in rows} == {
        (approach, *place, "z")
        for approach in ("moving-roughness", "full")
        for place in (("rail", None), ("ground", 8.0))
    }
    assert {(row[4], row[7]) for row in rows} == {("kb-f-max", "1"), ("ppv", "m/s")}
    assert all(row[6] > 0.0 for row in rows)


def test_errors_are_ratios_of_values(run):
    with connect(run) as connection:
        rows = connection.execute(
            "SELECT error_db, 20 * log10(value / reference_value) FROM passage_accuracy"
        ).fetchall()
    assert len(rows) == 2 * 7
    assert all(error == pytest.approx(ratio) for error, ratio in rows)


@pytest.mark.parametrize(
    "arguments", [["passages-that-exceed", "--set", "value=1e-9"], ["error-of-passages"]]
)
def test_shipped_questions_have_answers(run, arguments):
    name, *options = arguments
    answer = CliRunner().invoke(cli.queries, [name, str(run), "--format", "csv", *options])
    assert answer.exit_code == 0
    assert len(answer.output.splitlines()) > 1
