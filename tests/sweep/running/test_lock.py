import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from railvib.errors import InputError
from sweep.running import lock
from tests.sweep.driver import ROOT
from tests.sweep.small import STUDY, invoke

HOLD = """
import pathlib, sys, time
from sweep.running import lock
with lock.hold(pathlib.Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(100.0)
"""


def leave(directory, **changes):
    """Leave a lock as a process that died would."""
    directory.mkdir(exist_ok=True)
    with lock.hold(directory):
        note = json.loads((directory / lock.LOCK).read_text())
    (directory / lock.LOCK).write_text(json.dumps({**note, **changes}))


def ended():
    """Return the number of a process that has ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


@pytest.fixture
def other(tmp_path):
    """Return another process, which holds the lock of a directory."""
    command = [sys.executable, "-c", HOLD, tmp_path / "run"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_a_lock_names_its_holder_and_goes(tmp_path):
    with lock.hold(tmp_path / "run") as predecessor:
        holder = lock.holder(tmp_path / "run")
        assert predecessor is None
        assert (holder.pid, holder.alive) == (os.getpid(), True)
    assert os.listdir(tmp_path / "run") == []
    assert lock.holder(tmp_path / "run") is None


def test_a_second_holder_is_refused(tmp_path):
    with lock.hold(tmp_path):
        with pytest.raises(InputError, match=rf"is in use by process {os.getpid()} on ") as refusal:
            with lock.hold(tmp_path):
                pass
        assert "remove" not in str(refusal.value)
        assert lock.holder(tmp_path).pid == os.getpid()


def test_the_lock_lives_and_dies_with_its_process(tmp_path, other):
    """Whatever clocks show: no time is compared."""
    directory = tmp_path / "run"
    path = directory / lock.LOCK
    note = json.loads(path.read_text())
    path.write_text(json.dumps(note | {"since": "1970-01-01T00:00:00+00:00"}))
    assert lock.holder(directory).alive is True
    with pytest.raises(InputError, match=f"is in use by process {other.pid} on .* since 1970"):
        with lock.hold(directory):
            pass
    other.send_signal(signal.SIGSTOP)
    assert lock.holder(directory).alive is True
    other.kill()
    other.wait()
    assert lock.holder(directory).alive is False
    with lock.hold(directory) as predecessor:
        assert predecessor.pid == other.pid
        assert lock.holder(directory).pid == os.getpid()
    assert os.listdir(directory) == []


def test_a_later_process_of_the_same_number_is_another(tmp_path):
    leave(tmp_path, pid=os.getpid())
    assert lock.holder(tmp_path).alive is False
    with lock.hold(tmp_path) as predecessor:
        assert predecessor.pid == os.getpid()


def test_the_lock_of_another_host_is_left_to_the_user(tmp_path):
    leave(tmp_path, host="elsewhere", pid=ended())
    assert lock.holder(tmp_path).alive is None
    with pytest.raises(InputError, match=r"on elsewhere .* if it has ended, remove .*run\.lock"):
        with lock.hold(tmp_path):
            pass
    assert lock.holder(tmp_path).host == "elsewhere"


def test_a_holder_on_another_host_is_seen_where_locks_are_shared(tmp_path, other):
    path = tmp_path / "run" / lock.LOCK
    path.write_text(json.dumps(json.loads(path.read_text()) | {"host": "elsewhere"}))
    assert lock.holder(tmp_path / "run").alive is True


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
                with lock.hold(tmp_path):
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


def test_looking_at_a_dead_lock_does_not_keep_others_out(tmp_path):
    leave(tmp_path, pid=ended())
    stop = threading.Event()

    def look():
        while not stop.is_set():
            lock.holder(tmp_path)

    thread = threading.Thread(target=look)
    thread.start()
    try:
        for _ in range(20):
            with lock.hold(tmp_path):
                pass
    finally:
        stop.set()
        thread.join()


def test_a_lock_that_was_removed_and_made_anew_is_left_to_its_holder(tmp_path):
    with lock.hold(tmp_path):
        (tmp_path / lock.LOCK).unlink()
        with lock.hold(tmp_path):
            pass
        assert os.listdir(tmp_path) == []
        descriptor = os.open(tmp_path / lock.LOCK, os.O_CREAT)  # by another driver, which is inside
        os.close(descriptor)
    assert os.listdir(tmp_path) == [lock.LOCK]


@pytest.fixture
def without_locks(monkeypatch):
    """Let the file system have no locks."""

    def refuse(file, operation):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(lock.fcntl, "flock", refuse)


def test_without_locks_the_file_itself_is_one(tmp_path, without_locks):
    with lock.hold(tmp_path):
        assert lock.holder(tmp_path).alive is None
        with pytest.raises(InputError, match=r"is in use by process .* if it has ended, remove .*run\.lock"):
            with lock.hold(tmp_path):
                pass
    assert os.listdir(tmp_path) == []


def test_without_locks_a_dead_one_is_left_to_the_user(tmp_path, monkeypatch, without_locks):
    leave(tmp_path, pid=ended())
    with pytest.raises(InputError, match=r"is in use by process .* if it has ended, remove .*run\.lock"):
        with lock.hold(tmp_path):
            pass
    assert lock.holder(tmp_path).pid is not None


@pytest.mark.parametrize(
    "content",
    [b"", b"garbage", b"[1, 2]", b"null", b'{"pid": []}', b"\xff\x00", b"[" * 5000, b'{"pid": "x"}'],
)
def test_a_damaged_note_of_a_dead_process_is_taken_over(tmp_path, content):
    (tmp_path / lock.LOCK).write_bytes(content)
    assert lock.holder(tmp_path) == lock.Holder(alive=False)
    with lock.hold(tmp_path) as predecessor:
        assert predecessor is None
    assert os.listdir(tmp_path) == []


def test_a_damaged_note_of_a_living_process_keeps_others_out(tmp_path, other):
    (tmp_path / "run" / lock.LOCK).write_bytes(b"garbage")
    with pytest.raises(InputError, match="is in use by an unknown process$"):
        with lock.hold(tmp_path / "run"):
            pass


@pytest.mark.parametrize("kind", ["folder", "fifo", "link", "dangling link"])
@pytest.mark.parametrize("action", [lambda path: lock.hold(path).__enter__(), lock.holder])
def test_what_is_no_file_is_refused_and_left_alone(tmp_path, kind, action):
    path, target = tmp_path / "run" / lock.LOCK, tmp_path / "target"
    path.parent.mkdir()
    if kind == "folder":
        path.mkdir()
    elif kind == "fifo":
        os.mkfifo(path)
    else:
        path.symlink_to(target)
        if kind == "link":
            target.write_text("kept")
    with pytest.raises(InputError, match=r"run\.lock: .* remove it$"):
        action(path.parent)
    assert path.is_symlink() or path.exists()
    assert [other.read_text() for other in tmp_path.glob("target")] == ["kept"] * (kind == "link")


def test_a_run_refuses_a_directory_in_use(tmp_path):
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    with lock.hold(tmp_path / "out"):
        result = invoke("run", tmp_path / "small.toml", "--out", tmp_path / "out", "--workers", 0)
        assert os.listdir(tmp_path / "out") == [lock.LOCK]
    assert result.exit_code == 2
    assert f"is in use by process {os.getpid()} on " in result.output
