"""A folder whose entries somebody has replaced: nothing outside it is read, written or removed."""

import os
import uuid

import pytest

from sweep.storage.folder import Folder

KINDS = ["folder", "full folder", "fifo", "link", "dangling link", "link to itself", "long name"]


@pytest.fixture
def outside(tmp_path):
    """Return a folder with a file that is none of ours."""
    folder = tmp_path / "outside"
    folder.mkdir()
    (folder / "kept").write_bytes(b"kept")
    return folder


@pytest.fixture
def place(tmp_path):
    (tmp_path / "place").mkdir()
    return Folder(tmp_path / "place")


def put(kind, path, outside):
    """Put something at a path that no writer of ours leaves there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if kind.endswith("folder"):
        path.mkdir()
        if kind == "full folder":
            (path / "kept").write_bytes(b"kept")
    elif kind == "fifo":
        os.mkfifo(path)
    elif kind == "link":
        path.symlink_to(outside)
    elif kind == "dangling link":
        path.symlink_to(outside / "missing")
    elif kind == "link to itself":
        path.symlink_to(path)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_file_is_not_read_and_can_be_replaced(tmp_path, place, outside, kind):
    key = "records/" + ("n" * 300 if kind == "long name" else "a.json")
    path = tmp_path / "place" / key
    put(kind, path, outside)
    assert place.read(key) is None
    assert place.names(key) == ["kept"] * (kind in ("link", "full folder"))
    assert place.read_group("records", [key.rpartition("/")[2]]) == {}
    place.remove(key)
    place.remove(key)
    if kind != "long name":
        assert place.create(key, b"first")
        assert place.read(key) == b"first"
    kept = list(tmp_path.rglob("kept"))
    assert len(kept) == 1 + (kind == "full folder")
    assert {path.read_bytes() for path in kept} == {b"kept"}


@pytest.mark.parametrize("kind", KINDS[:-1])
def test_what_is_no_file_is_replaced_in_one_step(tmp_path, place, outside, kind):
    put(kind, tmp_path / "place" / "run.json", outside)
    place.replace("run.json", b"new")
    assert place.read("run.json") == b"new"
    assert (outside / "kept").read_bytes() == b"kept"
    assert len(list(tmp_path.rglob("kept"))) == 1 + (kind == "full folder")


@pytest.mark.parametrize("key", ["../outside/kept", "zarr/../../outside/kept", "..", "a\0b"])
def test_a_key_does_not_lead_out(place, outside, key):
    assert place.read(key) is None
    assert place.names(key) == []
    assert place.read_group(key) == {}
    assert place.read_group("zarr", [key]) == {}
    place.remove(key)
    for write in (place.create, place.replace, place.ensure):
        with pytest.raises(FileNotFoundError):
            write(key, b"new")
    assert (outside / "kept").read_bytes() == b"kept"


@pytest.mark.parametrize("kind", ["link", "dangling link", "link to itself", "fifo"])
def test_cleaning_follows_no_links(tmp_path, place, outside, kind):
    """Neither in place of the folder of what is being written, nor inside it."""
    (outside / uuid.uuid4().hex).mkdir()
    before = sorted(outside.rglob("*"))
    partial = tmp_path / "place" / "zarr.partial"
    put(kind, partial, outside)
    place.clean("zarr", 0.0)
    assert os.path.lexists(partial)
    partial.unlink()
    left = partial / uuid.uuid4().hex
    put(kind, left / "inside", outside)
    put(kind, partial / uuid.uuid4().hex, outside)
    place.clean("zarr", 0.0)
    assert not left.exists()
    assert sorted(outside.rglob("*")) == before


def test_cleaning_leaves_what_no_writer_left(tmp_path, place):
    partial = tmp_path / "place" / "zarr.partial"
    (partial / "notes").mkdir(parents=True)
    (partial / uuid.uuid4().hex).mkdir()
    place.clean("zarr", 0.0)
    assert os.listdir(partial) == ["notes"]


@pytest.mark.parametrize("kind", ["full folder", "link", "fifo"])
def test_a_group_takes_the_place_of_what_lies_there(tmp_path, place, outside, kind):
    put(kind, tmp_path / "place" / "zarr" / "group", outside)
    place.put("zarr/group", {"zarr.json": b"{}"})
    assert place.read_group("zarr/group") == {"zarr.json": b"{}"}
    assert [path.name for path in outside.iterdir()] == ["kept"]
