"""A folder of a file system as a location.

Keys may come from altered records and metadata. So no key leads out of the folder, only regular files are
read, and only a writer's leftovers are removed; of links the link itself, never its target.
"""

import errno
import filecmp
import os
import re
import shutil
import stat
import time
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from railvib.errors import InputError
from sweep.storage.protocol import NONE, Content

_UNREADABLE = (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.ELOOP, errno.ENXIO, errno.ENAMETOOLONG)
"""Errors that mean only that there is no such file, and say nothing about the disk."""
_TEMPORARY = re.compile(r"[0-9a-f]{32}")


class Folder:
    """A folder of a file system."""

    def __init__(self, path: Path | str) -> None:
        self._top = Path(path)
        self.address = str(path)
        # Paths are joined as text: for small files pathlib takes as long as the reading or writing.
        self._folder = f"{self._top}{os.sep}"

    def read(self, key: str) -> bytes | None:
        """Return a file's content."""
        try:
            return bytes(_read(self._path(key)))
        except OSError as error:
            if error.errno in _UNREADABLE:
                return None
            raise

    def read_many(self, keys: Iterable[str]) -> Iterator[bytes | None]:
        """Yield the contents of files."""
        return (self.read(key) for key in keys)

    def read_group(self, prefix: str, keys: Iterable[str] | None = None) -> Mapping[str, bytes | bytearray]:
        """Return all files below a folder, or some of them."""
        try:
            place = self._path(prefix)
        except FileNotFoundError:
            return {}
        contents: dict[str, bytes | bytearray] = {}
        for key in _keys(place) if keys is None else keys:
            try:
                contents[key] = _read(self._path(f"{prefix}/{key}"))
            except (
                OSError
            ) as error:  # may be in the middle of a replacement; the reader notices that it is missing
                if error.errno not in _UNREADABLE:
                    raise
        return contents

    def names(self, prefix: str) -> list[str]:
        """Return the names in a folder, without files that are being written."""
        try:
            with os.scandir(self._path(prefix)) as entries:
                return [entry.name for entry in entries if not entry.name.endswith(".partial")]
        except OSError as error:
            if error.errno in _UNREADABLE:
                return []
            raise

    def create(self, key: str, content: bytes) -> bool:
        """Do as `create_many`."""
        return self.create_many({key: content})[0]

    def create_many(self, contents: Mapping[str, bytes]) -> list[bool]:
        """Write temporary files, sync them, and link them to their names, which fails where one is taken.

        The first sync flushes the other files too; written one by one, each would wait for the disk.
        """
        temporary = {key: _temporary(self._path(key)) for key in contents}
        is_first = []
        try:
            for key, path in temporary.items():
                _write_below(path, contents[key])
            for path in temporary.values():
                _sync(path)
            for key, path in temporary.items():
                is_first.append(_link_first(path, self._path(key)))
        finally:
            for path in temporary.values():
                with suppress(FileNotFoundError, NotADirectoryError):
                    os.unlink(path)
        for folder in dict.fromkeys(map(os.path.dirname, temporary.values())):
            _sync(folder)  # makes the names durable too, not only the contents
        return is_first

    def ensure(self, key: str, content: bytes) -> None:
        """See that a file is there."""
        if not os.path.exists(self._path(key)):
            self.create(key, content)

    def replace(self, key: str, content: bytes) -> None:
        """Replace a file in one step; durable when this returns."""
        path = self._path(key)
        temporary = _temporary(path)
        _write_below(temporary, content)
        _sync(temporary)
        try:
            os.replace(temporary, path)
        except IsADirectoryError:
            _set_aside(path)
            os.replace(temporary, path)
        _sync(os.path.dirname(path))

    def put(self, prefix: str, objects: Mapping[str, Content], same: Mapping[str, str] = NONE) -> int:
        """Write a temporary folder and rename it to its place; anything in the way is renamed."""
        temporary = f"{self._folder}{self._partial(prefix)}/{uuid.uuid4().hex}"
        for folder in dict.fromkeys(key.rpartition("/")[0] for key in objects):
            _make_folder(f"{temporary}/{folder}" if folder else temporary)
        written = 0
        for key, content in objects.items():
            if key not in same or not _link(self._path(same[key]), f"{temporary}/{key}"):
                written += _write(f"{temporary}/{key}", content)
        _rename(temporary, self._path(prefix))
        return written

    def remove(self, key: str) -> None:
        """Remove a file or a link; a folder, which is not ours, is renamed."""
        try:
            os.unlink(self._path(key))
        except (IsADirectoryError, PermissionError):  # of a folder the latter on other systems than Linux
            if not os.path.isdir(self._path(key)):
                raise
            _set_aside(self._path(key))
        except OSError as error:
            if error.errno not in _UNREADABLE:
                raise

    def zarr(self, prefix: str) -> Path:
        """Return the path."""
        return Path(self._path(prefix))

    def check(self) -> None:
        """Check that the folder, or the nearest one above it that exists, can be written to."""
        nearest = next(path for path in (self._top, *self._top.absolute().parents) if path.exists())
        if not nearest.is_dir() or not os.access(nearest, os.W_OK | os.X_OK):
            raise InputError(f"--store = {self.address!r}: {nearest} is no folder that can be written to")

    def clean(self, prefix: str, older_than_s: float) -> None:
        """Remove unfinished groups of dead writers below a prefix."""
        folder = self._top / self._partial(prefix)
        if folder.is_symlink():
            return
        for name in filter(_TEMPORARY.fullmatch, self.names(folder.name)):
            path = folder / name
            with suppress(FileNotFoundError):
                state = path.lstat()
                if stat.S_ISDIR(state.st_mode) and time.time() - state.st_mtime >= older_than_s:
                    shutil.rmtree(path, ignore_errors=True)  # follows no links
        if older_than_s == 0.0:
            with suppress(OSError):  # it holds something else
                folder.rmdir()

    def _path(self, key: str) -> str:
        """Return the path of a key.

        Raises
        ------
        FileNotFoundError
            If the key leads out of the folder, or cannot be a path.
        """
        if "\0" in key or ".." in key and ".." in key.split("/"):
            raise FileNotFoundError(errno.ENOENT, "leads out of its folder", key)
        return self._folder + key

    @staticmethod
    def _partial(prefix: str) -> str:
        return f"{prefix.partition('/')[0]}.partial"


def _link(path: str, name: str) -> bool:
    """Link a file to a second name; return whether the file system can do that."""
    try:
        os.link(path, name)
    except OSError:
        return False
    return True


def _link_first(path: str, name: str) -> bool:
    """Link a file to a second name; return False if the name is taken: the first writer wins."""
    try:
        os.link(path, name)
    except FileExistsError:
        return False
    return True


def _make_folder(folder: str) -> None:
    """Create a folder and its parents if they are missing."""
    try:
        os.mkdir(folder)
    except FileExistsError:
        return
    except FileNotFoundError:
        os.makedirs(folder, exist_ok=True)


def _read(path: str) -> bytearray:
    """Return a regular file's content in writable memory, so that arrays need no copy.

    Raises
    ------
    IsADirectoryError
        If it is something else, such as a pipe; opening does not wait for the pipe's other end.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with open(descriptor, "rb", buffering=0) as file:
        state = os.fstat(descriptor)
        if not stat.S_ISREG(state.st_mode):
            raise IsADirectoryError(errno.EISDIR, "is no file", path)
        content = bytearray(state.st_size)
        file.readinto(content)
        return content


def _write(path: str, content: Content) -> int:
    """Write a file, and return how many bytes it has."""
    with open(path, "wb") as file:
        return sum(map(file.write, content if isinstance(content, tuple) else (content,)))


def _temporary(path: str) -> str:
    """Return a unique temporary name beside `path`."""
    folder, name = os.path.split(path)
    return f"{folder}/.{name}.{uuid.uuid4().hex}.partial"


def _write_below(path: str, content: bytes) -> None:
    """Write a file, and create its folder if missing."""
    try:
        _write(path, content)
    except FileNotFoundError:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        _write(path, content)


def _set_aside(path: str) -> None:
    """Rename whatever is in the way."""
    os.rename(path, f"{path}.{uuid.uuid4().hex[:8]}.damaged")


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
            _make_folder(above)
            continue
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
                raise
        if _is_same(Path(partial), Path(place)):
            shutil.rmtree(partial)
            return
        temporary = f"{os.path.dirname(partial)}/{uuid.uuid4().hex}"
        try:
            os.rename(place, temporary)
        except FileNotFoundError:  # another writer came first: try again
            continue
        if os.path.isdir(temporary) and not os.path.islink(temporary):
            shutil.rmtree(temporary)
        else:
            os.unlink(temporary)


def _is_same(one: Path, other: Path) -> bool:
    """Return whether two directories hold the same files with the same bytes."""
    keys = [sorted(_keys(str(top))) for top in (one, other)]
    return keys[0] == keys[1] and all(filecmp.cmp(one / key, other / key, shallow=False) for key in keys[0])


def _keys(top: str) -> Iterator[str]:
    """Yield the paths of all files below a folder, relative and with slashes; none if it is missing."""
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
