"""Names become parts of the names of files: what no system takes is no name."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.study.names import LONGEST, check_name


@pytest.mark.parametrize(
    "name", ["greby", "fra-hamid-yang-3", "Gröna_Tåget.2", "contour", "com", ".hidden", "n" * LONGEST, "軌道"]
)
def test_names(name):
    assert check_name(name) == name


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", "may consist of letters"),
        ("a b", "may consist of letters"),
        ("a/b", "may consist of letters"),
        ("a\\b", "may consist of letters"),
        ("a\n", "may consist of letters"),
        ("a–b", "may consist of letters"),
        ("*?[x]", "may consist of letters"),
        ("s3:x", "may consist of letters"),
        (".", "must not end with a dot"),
        ("..", "must not end with a dot"),
        ("greby.", "must not end with a dot"),
        ("CON", "is the name of a device"),
        ("nul.toml", "is the name of a device"),
        ("Com7", "is the name of a device"),
        ("n" * (LONGEST + 1), "has 101 bytes; must have at most 100"),
        ("ü" * 51, "has 102 bytes"),
    ],
)
def test_what_is_no_name(name, message):
    with pytest.raises(ValueError, match=message):
        check_name(name)


@given(st.text(max_size=120))
def test_a_name_makes_a_folder(tmp_path_factory, name):
    try:
        check_name(name)
    except ValueError:
        return
    path = tmp_path_factory.getbasetemp() / name
    path.mkdir()
    path.rmdir()
