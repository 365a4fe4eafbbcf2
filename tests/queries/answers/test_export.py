"""Results as Parquet files say the same as the database, to a reader that knows nothing of it."""

import csv

import duckdb
import pytest
from click.testing import CliRunner

from queries import cli
from queries.answers.export import PARTITIONS, SINGLE
from queries.database import connect, ingest


@pytest.fixture
def exported(study, tmp_path):
    soil = "x'; DROP TABLE cases; --/.."
    directory = study.write(soils=(soil,), lines=10)
    folder = tmp_path / "it's exported"
    result = CliRunner().invoke(cli.export, [str(directory), str(folder)])
    assert result.exit_code == 0, result.output
    return directory, folder


def test_every_row_is_in_the_files(exported):
    directory, folder = exported
    with connect(directory) as connection, duckdb.connect(":memory:") as reader:
        for table in (*PARTITIONS, *SINGLE):
            path = folder / table / "**" / "*.parquet" if table in PARTITIONS else folder / f"{table}.parquet"
            columns = [column[0] for column in connection.execute(f"FROM {table} LIMIT 0").description]
            names = ", ".join(f'"{name}"' for name in columns)
            found = reader.execute(
                f"SELECT {names} FROM read_parquet(?, hive_partitioning = true) ORDER BY ALL", [str(path)]
            ).fetchall()
            assert found == connection.execute(f"SELECT {names} FROM {table} ORDER BY ALL").fetchall(), table


def test_folders_are_named_by_what_they_hold(exported):
    _, folder = exported
    assert (folder / "levels" / "approach=full" / "quantity=velocity").is_dir()
    assert (folder / "psd" / "approach=full" / "case_id=case-0-150").is_dir()


def test_every_column_is_explained(exported):
    _, folder = exported
    with (folder / "columns.csv").open() as file:
        found = list(csv.DictReader(file))
    assert {row["table"] for row in found} == {*PARTITIONS, *SINGLE}
    assert all(row["meaning"] for row in found)


def test_a_folder_that_holds_something_is_left_alone(study, tmp_path):
    ingest(study.write(lines=10))
    (tmp_path / "mine").touch()
    result = CliRunner().invoke(cli.export, [str(study.directory), str(tmp_path)])
    assert result.exit_code == 2
    assert "is there already" in result.stderr
    assert (tmp_path / "mine").exists()
