"""What a place for results promises, on a file system and on S3 over the wire."""

import errno
import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from railvib.errors import InputError
from sweep.storage import bucket, folder, location
from tests.sweep.s3_server import SECRET, s3

__all__ = ["s3"]


@pytest.fixture(params=["folder", "bucket"])
def place(request, tmp_path):
    if request.param == "folder":
        return location.at(tmp_path / "new")
    return location.at(f"{request.getfixturevalue('s3')}/{tmp_path.name}/prefix")


def test_the_first_one_stays(place):
    assert place.create("records/a.json", b"first")
    assert not place.create("records/a.json", b"second")
    assert place.read("records/a.json") == b"first"


def test_one_of_many_at_once_is_first(place):
    start = threading.Barrier(8)

    def create(number):
        start.wait()
        return place.create("records/a.json", b"%d" % number)

    with ThreadPoolExecutor(8) as pool:
        won = list(pool.map(create, range(8)))
    assert sum(won) == 1
    assert place.read("records/a.json") == b"%d" % won.index(True)


def test_of_many_the_first_ones_stay(place):
    assert place.create("records/a/1", b"first")
    given = {"records/a/1": b"second", "records/a/2": b"second", "records/b/1": b"second"}
    assert place.create_many(given) == [False, True, True]
    late = dict.fromkeys([*given, "records/c"], b"third")
    assert place.create_many(late) == [False, False, False, True]
    assert list(place.read_many(late)) == [b"first", b"second", b"second", b"third"]
    assert place.create_many({}) == []


def test_a_disk_that_is_full_among_many_leaves_nothing_aside(tmp_path, monkeypatch):
    write, full = folder._write, OSError(errno.ENOSPC, "No space left on device")
    written = []

    def until_full(path, content):
        write(path, content[:1] if written else content)
        written.append(path)
        if len(written) == 2:
            raise full

    monkeypatch.setattr(folder, "_write", until_full)
    with pytest.raises(OSError, match="No space left"):
        location.at(tmp_path).create_many({f"records/{n}": b"content" for n in range(3)})
    assert len(written) == 2
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_what_is_there_can_be_listed_read_and_removed(place):
    assert place.names("records") == []
    assert place.read("records/a/1") is None
    for key in ("records/a/1", "records/a/2", "records/b/1"):
        place.create(key, key.encode())
    assert sorted(place.names("records")) == ["a", "b"]
    assert sorted(place.names("records/a")) == ["1", "2"]
    keys = ["records/b/1", "records/a/9", "records/a/1"]
    assert list(place.read_many(keys)) == [b"records/b/1", None, b"records/a/1"]
    place.remove("records/a/1")
    place.remove("records/a/1")
    assert place.names("records/a") == ["2"]


def test_a_group_is_whole_and_mended(place):
    assert place.read_group("zarr/group") == {}
    group = {"zarr.json": b"{}", "value/c/0": bytes(range(256))}
    place.put("zarr/group", group)
    assert place.read_group("zarr/group") == group
    assert place.read_group("zarr/group", ["zarr.json", "missing"]) == {"zarr.json": b"{}"}
    place.remove("zarr/group/value/c/0")
    place.put("zarr/group", {key: memoryview(content) for key, content in group.items()})
    assert place.read_group("zarr/group") == group


def test_what_never_changes_is_written_once(place):
    place.ensure("zarr/zarr.json", b"{}")
    place.ensure("zarr/zarr.json", b"{}")
    assert place.read("zarr/zarr.json") == b"{}"


@pytest.mark.parametrize(
    ("given", "address"),
    [
        ("s3://bucket/studies/", "s3://bucket/studies"),
        ("s3://bucket", "s3://bucket"),
        ("/data/shared", "/data/shared"),
    ],
)
def test_an_address_has_one_form(given, address):
    assert location.address(given) == address


@pytest.mark.parametrize(
    "given",
    [
        "gs://bucket/x",
        "s3://",
        "s3:///x",
        "s3://key:secret@bucket/x",
        "s3://Bucket",
        "s3://bucket/?key=secret",
    ],
)
def test_a_wrong_address_is_refused_without_its_secrets(given):
    with pytest.raises(InputError, match=r"must be .*s3://BUCKET/PREFIX") as refusal:
        location.address(given)
    assert "key:secret" not in str(refusal.value)
    assert "\n" not in str(refusal.value)


class Forbidding(BaseHTTPRequestHandler):
    """A server that lets nobody in."""

    def do_GET(self):
        self.send_error(403)

    def log_message(self, *_):
        pass


@pytest.fixture
def forbidding():
    with HTTPServer(("127.0.0.1", 0), Forbidding) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield server.server_port
        server.shutdown()
        thread.join()


@pytest.fixture
def closed():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        yield taken.getsockname()[1]


def test_digits_in_an_address_are_no_answer_of_a_server():
    message = "Error performing GET http://127.0.0.1:40321/b in 401.403ms - HTTP error: error sending request"
    assert bucket._reason(message) == "the server cannot be reached"


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"AWS_ACCESS_KEY_ID": ""}, "no credentials in the environment"),
        ({"AWS_SECRET_ACCESS_KEY": ""}, "no credentials in the environment"),
        ({"AWS_ALLOW_HTTP": "false"}, "is not encrypted; AWS_ALLOW_HTTP=true"),
        ({}, "there is no such bucket"),
        (
            {"AWS_ENDPOINT_URL": "http://127.0.0.1:{forbidding}"},
            "do not allow to list it",
        ),
        ({"AWS_ENDPOINT_URL": "http://127.0.0.1:{closed}"}, "the server cannot be reached"),
    ],
)
def test_a_bucket_that_cannot_be_used_is_told_in_one_line(
    s3, forbidding, closed, monkeypatch, change, reason
):
    for name, value in change.items():
        monkeypatch.setenv(name, value.format(forbidding=forbidding, closed=closed))
    location.at.cache_clear()
    with pytest.raises(InputError, match=reason) as refusal:
        location.at("s3://no-such-bucket/x").check()
    assert "\n" not in str(refusal.value)
    assert SECRET not in str(refusal.value)
    location.at.cache_clear()


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file is no folder that can be written to"):
        location.at(tmp_path / "file" / "store").check()
    location.at(tmp_path / "new" / "store").check()
