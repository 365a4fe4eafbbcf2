"""Kernels are compiled in a process of their own, and loaded by who computes."""

import os
import subprocess
import sys

import pytest

STAGES = """
import numba
import pathlib

@numba.njit(cache=True)
def twice(x):
    return 2 * x

def warm_up():
    with pathlib.Path(__file__).with_suffix(".calls").open("a") as file:
        file.write(".")
    assert twice(1) == 2
"""
LOAD = """
from sweep.processes import compiling
compiling.load("small_stages")
import small_stages
print(len(small_stages.twice.stats.cache_hits), len(small_stages.twice.stats.cache_misses))
"""


@pytest.fixture
def load(tmp_path):
    """Load stages of a kernel that is in no cache, in a process that has the environment of a new user."""
    (tmp_path / "small_stages.py").write_text(STAGES, encoding="utf-8")
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(tmp_path), os.getcwd()]),
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "NUMBA_CACHE_DIR": str(tmp_path / "compiled"),
    }

    def call():
        command = [sys.executable, "-c", LOAD]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    return call


def test_who_computes_does_not_compile(load, tmp_path):
    for calls in (2, 3):  # the first time once apart and once here, then here alone
        loaded = load()
        assert loaded.stdout.split() == ["1", "0"], loaded.stderr
        assert len(list(tmp_path.rglob("*.compiled"))) == 1
        assert len((tmp_path / "small_stages.calls").read_text(encoding="utf-8")) == calls


def test_what_cannot_be_compiled_is_told_once(load, tmp_path):
    (tmp_path / "small_stages.py").write_text(STAGES.replace("== 2", "== 3"), encoding="utf-8")
    for _ in range(2):
        loaded = load()
        assert loaded.returncode == 1
        assert loaded.stderr.count("Traceback") == loaded.stderr.count("AssertionError") == 1
    assert not list(tmp_path.rglob("*.compiled"))
