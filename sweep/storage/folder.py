"""A folder of a file system as a location."""

import errno
import filecmp
import os
import shutil
import time
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from railvib.errors import InputError
from sweep.storage.protocol import NONE, Content


class Folder:
    """A folder of a file system."""

    def __init__(self, path: Path | str) -> None:
        self._top = Path(path)
        self.address = str(path)
        # Paths are built from text below: objects of pathlib take as long as what is done with small files.
        self._folder = f"{self._top}{os.sep}"

    def read(self, key: str) -> bytes | None:
        """Return a file's content."""
        try:
            with open(self._folder + key, "rb") as file:
                return file.read()
        except (FileNotFoundError, NotADirectoryError):
            return None

    def read_many(self, keys: Iterable[str]) -> Iterator[bytes | None]:
        """Yield the contents of files."""
        return (self.read(key) for key in keys)

    def read_group(self, prefix: str, keys: Iterable[str] | None = None) -> Mapping[str, bytes | bytearray]:
        """Return all files below a folder, or some of them."""
        place = self._folder + prefix
        contents: dict[str, bytes | bytearray] = {}
        for key in _keys(place) if keys is None else keys:
            with suppress(FileNotFoundError):  # just being replaced: the reader will find that it is missing
                contents[key] = _read(f"{place}/{key}")
        return contents

    def names(self, prefix: str) -> list[str]:
        """Return what a folder holds but for files that are being written."""
        try:
            with os.scandir(self._folder + prefix) as entries:
                return [entry.name for entry in entries if not entry.name.endswith(".partial")]
        except (FileNotFoundError, NotADirectoryError):
            return []

    def create(self, key: str, content: bytes) -> bool:
        """Do as `create_many`."""
        return self.create_many({key: content})[0]

    def create_many(self, contents: Mapping[str, bytes]) -> list[bool]:
        """Write aside, sync, and link to the names, which fails where one is taken.

        What is synced first takes what else was written along: one by one each would wait for the disk.
        """
        asides = {key: _aside(self._folder + key) for key in contents}
        first = []
        try:
            for key, aside in asides.items():
                _write_aside(aside, contents[key])
            for aside in asides.values():
                _sync(aside)
            for key, aside in asides.items():
                first.append(_linked_first(aside, self._folder + key))
        finally:
            for aside in asides.values():
                with suppress(FileNotFoundError):
                    os.unlink(aside)
        for folder in dict.fromkeys(map(os.path.dirname, asides.values())):
            _sync(folder)  # makes the names durable, not only the files behind them
        return first

    def ensure(self, key: str, content: bytes) -> None:
        """See that a file is there."""
        if not os.path.exists(self._folder + key):
            self.create(key, content)

    def replace(self, key: str, content: bytes) -> None:
        """Write a file in one step, whatever was there; durable when this returns."""
        path = self._folder + key
        aside = _aside(path)
        _write_aside(aside, content)
        _sync(aside)
        os.replace(aside, path)
        _sync(os.path.dirname(path))

    def put(self, prefix: str, objects: Mapping[str, Content], same: Mapping[str, str] = NONE) -> int:
        """Write a folder aside, and rename it to its place; what is there already gets another name."""
        aside = f"{self._folder}{self._partial(prefix)}/{uuid.uuid4().hex}"
        for folder in dict.fromkeys(key.rpartition("/")[0] for key in objects):
            _make(f"{aside}/{folder}" if folder else aside)
        written = 0
        for key, content in objects.items():
            if key not in same or not _linked(self._folder + same[key], f"{aside}/{key}"):
                written += _write(f"{aside}/{key}", content)
        _rename(aside, self._folder + prefix)
        return written

    def remove(self, key: str) -> None:
        """Remove a file."""
        with suppress(FileNotFoundError):
            os.unlink(self._folder + key)

    def zarr(self, prefix: str) -> Path:
        """Return the path."""
        return self._top / prefix

    def check(self) -> None:
        """Check that the folder, or the nearest one above it that exists, can be written to."""
        nearest = next(path for path in (self._top, *self._top.absolute().parents) if path.exists())
        if not nearest.is_dir() or not os.access(nearest, os.W_OK | os.X_OK):
            raise InputError(f"--store = {self.address!r}: {nearest} is no folder that can be written to")

    def clean(self, prefix: str, older_than_s: float) -> None:
        """Remove what writers that died have left aside of groups below a first part of keys."""
        for name in self.names(self._partial(prefix)):
            path = self._top / self._partial(prefix) / name
            with suppress(FileNotFoundError):
                if time.time() - path.stat().st_mtime >= older_than_s:
                    shutil.rmtree(path, ignore_errors=True)

    @staticmethod
    def _partial(prefix: str) -> str:
        return f"{prefix.partition('/')[0]}.partial"


def _linked(path: str, name: str) -> bool:
    """Give a file another name; return whether that could be done: not every file system can."""
    try:
        os.link(path, name)
    except OSError:
        return False
    return True


def _linked_first(path: str, name: str) -> bool:
    """Give a file another name; return whether nothing had that: the first wins, whoever is slower."""
    try:
        os.link(path, name)
    except FileExistsError:
        return False
    return True


def _make(folder: str) -> None:
    """Make a folder if it is missing, and those above it."""
    try:
        os.mkdir(folder)
    except FileExistsError:
        return
    except FileNotFoundError:
        os.makedirs(folder, exist_ok=True)


def _read(path: str) -> bytearray:
    """Return a file's content in memory that can be written to, so that an array needs no copy of it."""
    with open(path, "rb", buffering=0) as file:
        content = bytearray(os.fstat(file.fileno()).st_size)
        file.readinto(content)
        return content


def _write(path: str, content: Content) -> int:
    """Write a file, and return how many bytes it has."""
    with open(path, "wb") as file:
        return sum(map(file.write, content if isinstance(content, tuple) else (content,)))


def _aside(path: str) -> str:
    """Return a name beside `path` that nobody else has."""
    folder, name = os.path.split(path)
    return f"{folder}/.{name}.{uuid.uuid4().hex}.partial"


def _write_aside(path: str, content: bytes) -> None:
    """Write a file in a folder that is made if missing."""
    try:
        _write(path, content)
    except FileNotFoundError:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        _write(path, content)


def _rename(partial: str, place: str) -> None:
    """Move a whole group to its place; one that is there stays if it is whole."""
    while True:
        try:
            os.rename(partial, place)
            return
        except FileNotFoundError:
            above = os.path.dirname(place)
            if os.path.isdir(above):
                raise
            _make(above)
            continue
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise
        if _same(Path(partial), Path(place)):
            shutil.rmtree(partial)
            return
        aside = f"{os.path.dirname(partial)}/{uuid.uuid4().hex}"
        try:
            os.rename(place, aside)
        except FileNotFoundError:  # another writer was as quick: try again
            continue
        shutil.rmtree(aside)


def _same(one: Path, other: Path) -> bool:
    """Return whether two directories hold the same files with the same bytes."""
    keys = [sorted(_keys(str(top))) for top in (one, other)]
    return keys[0] == keys[1] and all(filecmp.cmp(one / key, other / key, shallow=False) for key in keys[0])


def _keys(top: str) -> Iterator[str]:
    """Yield the paths of all files below a folder from there, with slashes; none where there is no folder."""
    for folder, _, names in os.walk(top):
        below = "" if folder == top else f"{os.path.relpath(folder, top)}/".replace(os.sep, "/")
        for name in names:
            yield below + name


def _sync(path: str) -> None:
    """Make a file, or the names in a folder, durable."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
