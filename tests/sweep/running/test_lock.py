import errno
import json
import os
import subprocess
import sys
import threading
import time

import psutil
import pytest

from railvib.errors import InputError
from sweep.running import lock
from tests.sweep.small import STUDY, invoke


def leave(directory, **changes):
    """Leave a lock as a process that died would."""
    directory.mkdir(exist_ok=True)
    with lock.held(directory):
        found = json.loads((directory / lock.LOCK).read_text())
    (directory / lock.LOCK).write_text(json.dumps({**found, **changes}))


def ended():
    """Return the number of a process that has ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_a_lock_names_its_holder_and_goes(tmp_path):
    with lock.held(tmp_path / "run") as predecessor:
        holder = lock.holder(tmp_path / "run")
        assert predecessor is None
        assert (holder.pid, holder.gone) == (os.getpid(), False)
    assert os.listdir(tmp_path / "run") == []


def test_a_second_holder_is_refused(tmp_path):
    with lock.held(tmp_path):
        with pytest.raises(InputError, match=rf"is in use by process {os.getpid()} on ") as refusal:
            with lock.held(tmp_path):
                pass
        assert "remove" not in str(refusal.value)
        assert lock.holder(tmp_path).pid == os.getpid()


def test_the_lock_of_a_dead_process_is_taken_over(tmp_path):
    leave(tmp_path, pid=ended())
    assert lock.holder(tmp_path).gone
    with lock.held(tmp_path) as predecessor:
        assert predecessor.gone
        assert lock.holder(tmp_path).pid == os.getpid()
    assert os.listdir(tmp_path) == []


def test_a_later_process_of_the_same_number_is_another(tmp_path):
    leave(tmp_path, process_began=psutil.Process().create_time() - 1000.0)
    with lock.held(tmp_path) as predecessor:
        assert predecessor.pid == os.getpid()


def test_the_lock_of_another_host_is_left_to_the_user(tmp_path):
    leave(tmp_path, host="elsewhere", pid=ended())
    with pytest.raises(InputError, match=r"on elsewhere .* if it runs no more, remove .*run\.lock"):
        with lock.held(tmp_path):
            pass
    assert lock.holder(tmp_path).host == "elsewhere"


@pytest.mark.parametrize("attempt", range(20))
def test_one_of_many_takes_over(tmp_path, attempt):
    """Threads of one process stand for drivers: each tries until it has been in, one at a time."""
    leave(tmp_path, pid=ended())
    inside, most, entered = 0, 0, 0
    guard = threading.Lock()
    patience = time.monotonic() + 60.0

    def enter():
        nonlocal inside, most, entered
        while time.monotonic() < patience:
            try:
                with lock.held(tmp_path):
                    with guard:
                        inside, entered = inside + 1, entered + 1
                        most = max(most, inside)
                    with guard:
                        inside -= 1
                return
            except InputError:
                continue

    threads = [threading.Thread(target=enter) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (most, entered) == (1, 8)
    assert os.listdir(tmp_path) == []


def test_who_comes_late_to_a_dead_lock_leaves_the_new_one_where_it_is(tmp_path):
    leave(tmp_path, pid=ended())
    dead, path = lock.holder(tmp_path), tmp_path / lock.LOCK
    with lock.held(tmp_path):
        before = path.stat()
        assert not lock._remove(path, dead)
        assert path.stat().st_ctime_ns == before.st_ctime_ns  # which moving it away and back would change


def test_a_dead_lock_that_cannot_be_taken_over_is_left_to_the_user(tmp_path, monkeypatch):
    def without_locks(file, operation):
        raise OSError(errno.ENOLCK, "No locks available")

    leave(tmp_path, pid=ended())
    monkeypatch.setattr(lock.fcntl, "flock", without_locks)
    with pytest.raises(InputError, match=r"run\.lock: .* runs no more, .* \(No locks available\); remove it"):
        with lock.held(tmp_path):
            pass
    assert lock.holder(tmp_path).gone


def test_a_run_refuses_a_directory_in_use(tmp_path):
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    with lock.held(tmp_path / "out"):
        result = invoke("run", tmp_path / "small.toml", "--out", tmp_path / "out", "--workers", 0)
        assert os.listdir(tmp_path / "out") == [lock.LOCK]
    assert result.exit_code == 2
    assert f"is in use by process {os.getpid()} on " in result.output
