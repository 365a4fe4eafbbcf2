"""The distribution: what the wheel holds, what it says of itself, and the two ways to start the program."""

import subprocess
import sys
import tomllib
import zipfile
from email.parser import Parser
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("railvib", "sweep", "queries")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Return a wheel built from the source tree."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (path,) = folder.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        yield archive


def test_the_wheel_holds_the_three_packages_whole_and_nothing_else(wheel):
    sources = {
        str(path.relative_to(ROOT))
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    information = f"railvib-{PROJECT['version']}.dist-info/"
    assert {name for name in wheel.namelist() if not name.startswith(information)} == sources
    assert {Path(name).suffix for name in sources} >= {".py", ".toml", ".sql", ".html", ".js", ".css"}


def test_the_wheel_names_licence_and_authors(wheel):
    information = f"railvib-{PROJECT['version']}.dist-info/"
    fields = Parser().parsestr(wheel.read(f"{information}METADATA").decode())
    assert fields["License-Expression"] == "BSD-3-Clause"
    assert fields["Author"] == "railvib developers"
    assert wheel.read(f"{information}licenses/LICENSE") == (ROOT / "LICENSE").read_bytes()


def test_citation_and_changelog_know_the_version():
    assert f"\nversion: {PROJECT['version']}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\n## [{PROJECT['version']}] - " in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("program", [["-m", "railvib"], ["-c", "from railvib.cli import main; main()"]])
def test_the_program_tells_its_version(program):
    started = subprocess.run(
        [sys.executable, *program, "--version"], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert started.stdout.split()[-1] == metadata.version("railvib") == PROJECT["version"]


def test_the_module_is_called_by_the_name_of_the_program():
    started = subprocess.run(
        [sys.executable, "-m", "railvib", "--help"], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert started.stdout.startswith("Usage: railvib [OPTIONS] COMMAND")
    assert {"library", "plan", "run", "report"} <= set(started.stdout.split())
