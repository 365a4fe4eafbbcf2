"""What is done: one small JSON file per stored unit, written after its arrays, and one manifest per run.

A commit record is written aside, synced and linked to its name, so that it is whole and the first one stays;
its presence means that the unit is done. It ends with its own checksum: one that is torn or altered counts as
absent. Failures lie beside them under `failed`, manifests under `runs`; `run.json` is the latest manifest.
Everything else, the database included, can be rebuilt from these files and the store.
"""

import contextlib
import hashlib
import json
import os
import uuid
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

SCHEMA = 2
_WITHOUT_CHECKSUM = 1
"""The schema before records had checksums."""
RECORDS = "records"
MANIFEST = "run.json"
_CHECKSUM = "sha256"
_FAILED = "failed"
_RUNS = "runs"


class Run:
    """The manifests of a run directory: the latest as `run.json`, every one under `records/runs`."""

    @staticmethod
    def load(directory: Path | str) -> dict[str, Any]:
        """Return the latest manifest of a run directory, where `run.json` is damaged its copy.

        Raises
        ------
        FileNotFoundError
            If the directory holds no run.
        """
        path = Path(directory) / MANIFEST
        found = _decode(path) or next(reversed(runs(directory)), None)
        if found is None:
            raise FileNotFoundError(path)
        return found

    @staticmethod
    def publish(directory: Path | str, manifest: Mapping[str, Any]) -> None:
        """Write a manifest under its run id and as the latest one, each replaced in one step."""
        content = _encode(manifest)
        for path in (
            Path(directory) / RECORDS / _RUNS / f"{manifest['run_id']}.json",
            Path(directory) / MANIFEST,
        ):
            _replace(path, content)


def runs(directory: Path | str) -> list[dict[str, Any]]:
    """Return the manifests of all runs of a directory, the earliest first."""
    manifests = [content for _, content in _records(Path(directory) / RECORDS / _RUNS)]
    return sorted(manifests, key=lambda manifest: (manifest["started"], manifest["run_id"]))


def committed(directory: Path | str, kind: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the commit records of a run directory, of one kind or of all, by kind and id."""
    for folder in [Path(directory) / RECORDS / kind] if kind else _kinds(directory):
        yield from (content for _, content in _records(folder))


def failed(directory: Path | str) -> Iterator[dict[str, Any]]:
    """Yield the records of failures that no later attempt has made good."""
    for _, content in _records(Path(directory) / RECORDS / _FAILED):
        if not _path(directory, content["kind"], content["unit_id"]).exists():
            yield content


def present(directory: Path | str) -> set[str]:
    """Return the ids of all committed units, from the names of their records alone."""
    return {
        entry.name.removesuffix(".json")
        for folder in _kinds(directory)
        for entry in os.scandir(folder)
        if entry.name.endswith(".json")
    }


def find(directory: Path | str, kind: str, unit_id: str) -> dict[str, Any] | None:
    """Return the commit record of a unit, or None where there is none that can be read."""
    return _decode(_path(directory, kind, unit_id))


def commit(directory: Path | str, record: Mapping[str, Any]) -> bool:
    """Write a commit record unless there is one; return whether this one is the first and so counts.

    A failure recorded earlier for the same unit is withdrawn.
    """
    path = _path(directory, record["kind"], record["unit_id"])
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = _write_aside(path, _encode(record))
    try:
        os.link(temporary, path)  # fails where the name is taken: the first wins, whoever is slower
        first = True
    except FileExistsError:
        first = _decode(path) is None
        if first:  # one that cannot be read holds its name for nothing
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    _sync_folder(path.parent)
    _failure(directory, record["unit_id"]).unlink(missing_ok=True)
    return first


def fail(directory: Path | str, record: Mapping[str, Any]) -> None:
    """Write the record of a failure; a later one of the same unit replaces it."""
    _replace(_failure(directory, record["unit_id"]), _encode(record))


def withdraw(directory: Path | str, kind: str, unit_id: str) -> None:
    """Take back the commit record of a unit whose arrays were found damaged, so that it is computed again."""
    with contextlib.suppress(FileNotFoundError):
        _path(directory, kind, unit_id).unlink()


def _path(directory: Path | str, kind: str, unit_id: str) -> Path:
    return Path(directory) / RECORDS / kind / f"{unit_id}.json"


def _failure(directory: Path | str, unit_id: str) -> Path:
    return Path(directory) / RECORDS / _FAILED / f"{unit_id}.json"


def _kinds(directory: Path | str) -> list[Path]:
    """Return the folders that hold commit records, in order of their kind."""
    top = Path(directory) / RECORDS
    if not top.is_dir():
        return []
    return sorted(path for path in top.iterdir() if path.is_dir() and path.name not in (_FAILED, _RUNS))


def _records(folder: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield the readable records of a folder in order of their names."""
    for path in sorted(folder.glob("*.json")):
        content = _decode(path)
        if content is not None:
            yield path, content


def _decode(path: Path) -> dict[str, Any] | None:
    """Return the content of a record, or None where it is missing, torn or altered."""
    try:
        encoded = path.read_bytes()
        content: dict[str, Any] = json.loads(encoded)
    except (FileNotFoundError, json.JSONDecodeError, UnicodeDecodeError):
        return None
    said = content.pop(_CHECKSUM, None)
    body = encoded[: encoded.rfind(f',"{_CHECKSUM}":'.encode())]
    whole = said == hashlib.sha256(body).hexdigest() or content.get("schema") == _WITHOUT_CHECKSUM
    return content if whole else None


def _encode(content: Mapping[str, Any]) -> bytes:
    """Return a record as one line of JSON, with the sha256 of all that stands before as its last entry."""
    body = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))[:-1].encode()
    return body + f',"{_CHECKSUM}":"{hashlib.sha256(body).hexdigest()}"}}\n'.encode()


def _replace(path: Path, content: bytes) -> None:
    """Write a file in one step, durable when this returns."""
    path.parent.mkdir(parents=True, exist_ok=True)
    _write_aside(path, content).replace(path)
    _sync_folder(path.parent)


def _write_aside(path: Path, content: bytes) -> Path:
    """Write and sync a file beside `path` under a name of its own."""
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex}.partial")
    with temporary.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    return temporary


def _sync_folder(folder: Path) -> None:
    """Make the names in a folder durable, not only the files behind them."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
