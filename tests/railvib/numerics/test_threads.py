"""Linear algebra keeps to one thread, whichever library it comes from."""

import subprocess
import sys

import pytest

CODE = """
from railvib.numerics import threads
import scipy.linalg
import threadpoolctl
with threads.single():
    for library in threadpoolctl.threadpool_info():
        print(library["user_api"], library["num_threads"])
"""


@pytest.mark.parametrize("first", ["", "import numpy", "import scipy.linalg"])
def test_every_library_is_limited_however_it_came_in(first):
    said = subprocess.run([sys.executable, "-c", first + CODE], capture_output=True, text=True, check=True)
    assert {line for line in said.stdout.splitlines() if line.startswith("blas")} == {"blas 1"}
