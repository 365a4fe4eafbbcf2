"""The database of benchmarks is built from their files, and its columns have comments."""

import json

import duckdb

from benchmarks import database

DOCUMENT = {
    "schema": 1,
    "size": "quick",
    "started": "2026-01-02T03:04:05.678+00:00",
    "finished": "2026-01-02T03:06:05.678+00:00",
    "host": "here",
    "host_class": "a processor x2",
    "processors": 2,
    "load_before": 0.1,
    "load_after": 1.0,
    "commit": "0123456789ab",
    "model_version": "1",
    "versions": {"railvib": "0.1.0"},
    "rates": {"operations": 5e10, "divisions": 3e9, "roots": 2e9},
    "figures": [
        {
            "section": "kernel",
            "item": "Q33",
            "case": "3 layers",
            "quantity": "rate",
            "unit": "1/s",
            "samples": [1e7, 2e7, 4e7],
            "at_least": 1.5e7,
            "at_most": None,
            "median": 2e7,
            "lower_quartile": 1.5e7,
            "upper_quartile": 3e7,
            "holds": True,
        }
    ],
}


def test_every_file_of_a_folder_becomes_rows(tmp_path):
    for hour in ("03", "04"):
        content = {**DOCUMENT, "started": f"2026-01-02T{hour}:04:05.678+00:00"}
        (tmp_path / f"benchmark-2026-01-02T{hour}0405.json").write_text(json.dumps(content), "utf-8")
        path = database.rebuild(tmp_path)
    with duckdb.connect(str(path), read_only=True) as connection:
        assert connection.execute(
            'SELECT benchmark, section, "case", samples, median, holds FROM figures ORDER BY benchmark'
        ).fetchall() == [
            (f"benchmark-2026-01-02T{hour}0405", "kernel", "3 layers", [1e7, 2e7, 4e7], 2e7, True)
            for hour in ("03", "04")
        ]
        assert connection.execute(
            "SELECT host, git_commit, versions->>'railvib', operations_per_s FROM benchmarks LIMIT 1"
        ).fetchone() == ("here", "0123456789ab", "0.1.0", 5e10)
        uncommented = connection.execute(
            "SELECT column_name FROM duckdb_columns() WHERE comment IS NULL AND NOT internal"
        )
        assert uncommented.fetchall() == []
    assert [path.name for path in tmp_path.iterdir() if "partial" in path.name] == []
