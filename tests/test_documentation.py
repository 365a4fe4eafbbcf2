"""The documentation: its examples run, its links lead somewhere, and the files that it names exist."""

import doctest
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
EXAMPLES = [page for page in PAGES if ">>>" in page.read_text(encoding="utf-8")]
LINK = re.compile(r"\]\((?!https?:)([^)#\s]+)")
MODULE_LINE = re.compile(r"^Modules?:.*?\.(?=\s|$)", re.MULTILINE | re.DOTALL)
SOURCE_FILE = re.compile(r"(?<![\w/.])(?:\w+/)*[a-z0-9_]+\.(?:py|sql)\b")
SOURCES = [
    path
    for folder in ("railvib", "sweep", "queries", "benchmarks", "tests", "scripts", "studies")
    for path in (ROOT / folder).rglob("*.*")
]
DECISIONS = ROOT / "docs" / "decisions"


def name(page):
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", EXAMPLES, ids=name)
def test_examples_print_what_they_say(page):
    result = doctest.testfile(str(page), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_to_files(page):
    links = LINK.findall(page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "theory").glob("*.md")), ids=name)
def test_theory_names_modules_that_exist(page):
    line = MODULE_LINE.search(page.read_text(encoding="utf-8"))
    modules = re.findall(r"`([a-z_/]+)`", line.group())
    assert modules
    assert [module for module in modules if not (ROOT / "railvib" / f"{module}.py").is_file()] == []


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_pages_name_source_files_that_exist(page):
    """A file may be named without the folders that lead to it; NAME stands for one to be written."""
    files = [f"/{path.relative_to(ROOT)}" for path in SOURCES]
    named = SOURCE_FILE.findall(page.read_text(encoding="utf-8"))
    assert [file for file in named if not any(path.endswith(f"/{file}") for path in files)] == []


def test_every_decision_is_listed_once():
    listed = LINK.findall((DECISIONS / "README.md").read_text(encoding="utf-8"))
    pages = [path.name for path in DECISIONS.glob("*.md") if path.name != "README.md"]
    assert sorted(link for link in listed if "/" not in link) == sorted(pages)


def test_walks_pass_through_twelve_files_at_most_and_none_twice():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = text.partition("## Two walks")[2]
    walks = [re.findall(r"^ {4}(\S+)", block, re.MULTILINE) for block in section.split(":\n")[1:]]
    assert len(walks) == 2
    for files in walks:
        assert [file for file in files if not (ROOT / file).is_file()] == []
        assert len(set(files)) == len(files) <= 12
