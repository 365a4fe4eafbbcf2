"""Tables of any origin: how deep, how large, how spelt."""

import pytest

from railvib.errors import InputError
from sweep.study.tables import DEEPEST, plain


def nested(depth):
    table = {"a": 1}
    for _ in range(depth):
        table = {"a": table}
    return table


def test_every_text_is_in_one_form():
    assert plain({"Mu\u0308": ["a\u030a", {"u\u0308": ("o\u0308",)}]}) == {"Mü": ["å", {"ü": ["ö"]}]}


def test_what_is_no_text_stays():
    tables = {"a": [1, 2.5, True, {"b": None}], "c": 2**53}
    assert plain(tables) == tables


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"ü": 1, "u\u0308": 2}, "ü: is there twice"),
        ({"a": {"b": [2**53 + 1]}}, r"a.b\[0\] = 9007199254740993: must be between"),
        ({"a": -(10**5000)}, "a = int too large to show: must be between"),
        (nested(DEEPEST), "is nested too deeply"),
        (nested(500), "is nested too deeply"),
        ({"k" * 10**6: nested(500)}, "is nested too deeply"),
    ],
    ids=range(6),
)
def test_refused_tables(tables, message):
    with pytest.raises(InputError, match=message) as refusal:
        plain(tables)
    assert len(str(refusal.value)) < 500


def test_the_deepest_tables():
    assert plain(nested(DEEPEST - 1)) == nested(DEEPEST - 1)
