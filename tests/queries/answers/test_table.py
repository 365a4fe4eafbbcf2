import io

import pytest
from rich.console import Console

from queries.answers.table import Table, band, decibels, number, plain, printable


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (float("nan"), "–"),
        (0.0, "0"),
        (1234.5, "1,234"),
        (12.345, "12.3"),
        (0.0123456, "0.0123"),
        (-0.5, "-0.500"),
    ],
)
def test_numbers_have_three_significant_digits_and_no_exponent(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(None, "–"), (0.0, "+0.0"), (-0.04, "+0.0"), (-3.0, "-3.0"), (6.25, "+6.2")]
)
def test_differences_of_levels_have_a_sign(value, text):
    assert decibels(value) == text


def test_bands_are_named_as_in_the_standard():
    exact = [10.0 ** (index / 10.0) for index in range(0, 21)]
    nominal = "1 1.25 1.6 2 2.5 3.15 4 5 6.3 8 10 12.5 16 20 25 31.5 40 50 63 80 100".split()
    assert [band(value) for value in exact] == nominal


def test_text_cannot_steer_a_terminal():
    assert printable("a\x1b[31mb\nc") == "a [31mb c"
    assert plain("_hidden") == " _hidden"


def test_a_file_gets_whole_cells_however_long():
    long = "x" * 300
    file = io.StringIO()
    Table("title", ("name", "value"), ((long, "1"), ("short", "22")), note="a note").show(Console(file=file))
    lines = file.getvalue().splitlines()
    assert lines[0] == "title"
    assert [long, "1"] in [line.split() for line in lines]
    assert lines[-1].strip() == "a note"
