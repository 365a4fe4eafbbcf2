import duckdb
import numpy as np
import pytest

from queries.database import rows
from queries.database.rows import Writer


@pytest.fixture
def connection():
    with duckdb.connect(":memory:") as connection:
        connection.execute("CREATE TABLE lines (name VARCHAR, number INTEGER, value DOUBLE, start TIMESTAMP)")
        connection.begin()
        yield connection


def content(connection):
    return connection.execute("SELECT name, number, value, start::VARCHAR FROM lines ORDER BY ALL").fetchall()


def test_what_a_row_lacks_is_null_and_what_a_table_lacks_is_left_out(connection):
    start = "2026-03-01 08:00:00"
    writer = Writer(connection)
    writer.rows("lines", [{"name": "a", "number": 1, "other": 5}, {"value": 2.5, "start": start}])
    assert content(connection) == [
        ("a", 1, None, None),
        (None, None, 2.5, start),
    ]


def test_rows_that_agree_in_some_columns_are_replaced(connection):
    writer = Writer(connection)
    writer.rows("lines", [{"name": name, "number": 1} for name in "abc"])
    writer.rows("lines", [{"name": "b", "number": 2}], replacing=("name",))
    assert content(connection) == [("a", 1, None, None), ("b", 2, None, None), ("c", 1, None, None)]


@pytest.mark.parametrize("held_rows", [0, 5, 1000])
@pytest.mark.parametrize("names", [("a", "b", None), (None, None, None)])
def test_stretches_are_the_rows_that_they_stand_for(connection, monkeypatch, held_rows, names):
    monkeypatch.setattr(rows, "_HELD_ROWS", held_rows)
    writer = Writer(connection)
    values = np.array([[1.0, np.nan], [3.0, 4.0], [5.0, 6.0]])
    for shift in (0.0, 10.0):  # numbers may be views with fewer elements than rows
        heads = [{"name": name, "number": number} for number, name in enumerate(names)]
        writer.stretches("lines", heads, {"value": np.broadcast_to(values + shift, (3, 2))})
    writer.flush()
    expected = [
        (name, number, None if np.isnan(value) else value + shift, None)
        for shift in (0.0, 10.0)
        for number, name in enumerate(names)
        for value in values[number].tolist()
    ]
    assert sorted(content(connection), key=repr) == sorted(expected, key=repr)
