"""Machines on which no worker process can be started: one line that names the cause."""

import os
import resource
import shutil
import subprocess
import sys

import pytest

from railvib.errors import InputError
from sweep.processes import surroundings
from tests.sweep.small import STUDY

RUN = f"{sys.executable} -m railvib run small.toml --workers 1"
HIDDEN = {
    "ulimit -n": f"ulimit -n 32; {RUN}",
    "TMPDIR": f"mkdir -p {'x' * 80}; TMPDIR=$PWD/{'x' * 80} {RUN}",
    "/dev/shm": f"unshare --mount sh -c 'mount -t tmpfs -o ro none /dev/shm; {RUN}'",
    "127.0.0.1": f"unshare --net {RUN}",
    "/proc": f"unshare --mount sh -c 'mount -t tmpfs none /proc; {RUN}'",
}


def test_this_machine_will_do():
    surroundings.check(2)


def test_more_workers_need_more_files(monkeypatch):
    monkeypatch.setattr(resource, "getrlimit", lambda _limit: (100, 100))
    surroundings.check(2)
    with pytest.raises(InputError, match=r"ulimit -n = 100: 100 workers need at least 1040 open files"):
        surroundings.check(100)


@pytest.mark.privileged
@pytest.mark.parametrize("cause", HIDDEN)
def test_what_is_missing_is_named_in_one_line(tmp_path, cause):
    if "unshare" in HIDDEN[cause] and (os.geteuid() != 0 or shutil.which("unshare") is None):
        pytest.skip("needs root to hide it")
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    done = subprocess.run(
        HIDDEN[cause], shell=True, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith(f"Error: {cause}")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "runs").exists()
