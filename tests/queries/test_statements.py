"""Statements are found by their names, and none lies in a file unused."""

import re
from pathlib import Path

import pytest

from queries.statements import statements

QUERIES = Path(__file__).parents[2] / "queries"
FILES = sorted(path for path in QUERIES.rglob("*.sql") if "-- name: " in path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_statement_of_a_file_is_run_by_name(path):
    room = ".".join(("queries", *path.relative_to(QUERIES).parts[:-1]))
    named = statements(room, path.stem)
    assert all(named.values())
    code = "".join(module.read_text(encoding="utf-8") for module in QUERIES.rglob("*.py"))
    patterns = re.findall(r"""_[A-Z]+\[f?["']([a-z0-9{}-]+)["']\]""", code)  # such as page-{name}
    used = re.compile("|".join(re.sub(r"\{\w*\}", ".*", pattern) for pattern in patterns))
    assert [name for name in named if not used.fullmatch(name)] == []


def test_a_statement_is_what_stands_below_its_name():
    assert statements("queries.answers", "summary")["missing"].startswith("SELECT")
