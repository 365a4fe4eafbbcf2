"""Records of finished work: one small JSON file per stored unit, written after its arrays, and manifests.

A unit is done when it has a commit record; the first record stays. A record ends with its own checksum; a
torn or altered one counts as absent. Records lie with their arrays: in the run directory, or in a shared
store that the manifests name. Failures and manifests lie in the run directory, under `failed` and `runs`;
`run.json` is the latest manifest. Everything else, including the database, can be rebuilt from these files
and the arrays.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from sweep.storage import location
from sweep.storage.folder import Folder
from sweep.storage.forms import Form, is_failure, is_manifest, is_record

SCHEMA = 2
_WITHOUT_CHECKSUM = 1
"""Schema of records without checksums, before they had any."""
RECORDS = "records"
MANIFEST = "run.json"
_CHECKSUM = "sha256"
_FAILED = "failed"
_RUNS = "runs"

Home = Path | str
"""Where units are stored: the path of a run directory, or the path or address of a shared store."""


class Run:
    """The manifests of a run directory: the latest as `run.json`, every one under `records/runs`."""

    @staticmethod
    def load(directory: Path | str) -> dict[str, Any]:
        """Return the latest manifest of a run directory; if `run.json` is damaged, its copy.

        Raises
        ------
        FileNotFoundError
            If the directory holds no run.
        """
        manifest = _decode(Folder(directory).read(MANIFEST), is_manifest)
        manifest = manifest or next(reversed(runs(directory)), None)
        if manifest is None:
            raise FileNotFoundError(Path(directory) / MANIFEST)
        return manifest

    @staticmethod
    def publish(directory: Path | str, manifest: Mapping[str, Any]) -> None:
        """Write a manifest under its run id and as the latest one, each replaced in one step."""
        content = _encode(manifest)
        for key in (f"{RECORDS}/{_RUNS}/{manifest['run_id']}.json", MANIFEST):
            Folder(directory).replace(key, content)


def runs(directory: Path | str) -> list[dict[str, Any]]:
    """Return the manifests of all runs of a directory, the earliest first."""
    manifests = _folder(directory, _RUNS, is_manifest)
    return sorted(manifests, key=lambda manifest: (manifest["started"], manifest["run_id"]))


def homes(directory: Path | str) -> tuple[Home, ...]:
    """Return where the units of a run directory are stored: there, and in the store of its latest run."""
    path = Path(directory) / MANIFEST
    try:
        state = path.stat()
        outside = _store(Path(directory), state.st_mtime_ns, state.st_size)
    except (FileNotFoundError, NotADirectoryError):
        return (directory,)
    return (directory, outside) if outside else (directory,)


@lru_cache(16)
def _store(directory: Path, changed: int, size: int) -> str | None:
    """Return the store that the manifest of a directory names; cached, as manifests may be large."""
    named: str | None = Run.load(directory).get("store")
    return named


def commits(directory: Path | str, stage: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the commit records of a run directory, of one stage or of all, by stage and id.

    Of a shared store, only units that a run of the directory needs are included.
    """
    run, *outside = homes(directory)
    keys_by_home = {home: _entries(home, stage) for home in (run, *outside)}
    needed = _ids_of_runs(directory) if outside else set()
    for home in outside:
        keys_by_home[home] = [
            key for key in keys_by_home[home] if key[1] in needed and key not in keys_by_home[run]
        ]
    contents = {
        home: location.at(home).read_many(_key(*key) for key in keys) for home, keys in keys_by_home.items()
    }
    for (_, unit_id), home in sorted((key, home) for home, keys in keys_by_home.items() for key in keys):
        record = _record(unit_id, next(contents[home]))
        if record is not None:
            yield record


def failures(directory: Path | str) -> Iterator[dict[str, Any]]:
    """Yield the records of failures whose units are still not done."""
    for failure in _folder(directory, _FAILED, is_failure):
        if all(find(home, failure["kind"], failure["unit_id"]) is None for home in homes(directory)):
            yield failure


def ids_of(directory: Path | str) -> set[str]:
    """Return the ids of all units of a run directory that have a record, from file names alone."""
    run, *outside = homes(directory)
    ids = ids_at(run)
    for home in outside:
        ids |= ids_at(home) & _ids_of_runs(directory)
    return ids


def ids_at(home: Home) -> set[str]:
    """Return the ids of all units that have a record at one place, whichever run computed them."""
    return {unit_id for _, unit_id in _entries(home)}


def find(home: Home, stage: str, unit_id: str) -> dict[str, Any] | None:
    """Return the commit record of a unit at one place, or None where there is none that can be read."""
    return _record(unit_id, location.at(home).read(_key(stage, unit_id)))


def commit(home: Home, record: Mapping[str, Any]) -> bool:
    """Write a commit record unless there is one; return whether this is the first, which counts."""
    return commit_many(home, [record])[0]


def commit_many(home: Home, batch: Sequence[Mapping[str, Any]]) -> list[bool]:
    """Write commit records of several units; return for each whether it is the first."""
    place = location.at(home)
    contents = {_key(record["kind"], record["unit_id"]): _encode(record) for record in batch}
    is_first = place.create_many(contents)
    for number, (record, (key, content)) in enumerate(zip(batch, contents.items(), strict=True)):
        if not is_first[number] and _record(record["unit_id"], place.read(key)) is None:
            place.remove(key)  # an unreadable record must not block the unit
            is_first[number] = place.create(key, content)
    return is_first


def withdraw(home: Home, stage: str, unit_id: str) -> None:
    """Remove the commit record of a damaged unit, so that it is computed again."""
    location.at(home).remove(_key(stage, unit_id))


def fail(directory: Path | str, record: Mapping[str, Any]) -> None:
    """Write the record of a failure; a later one of the same unit replaces it."""
    Folder(directory).replace(_key(_FAILED, record["unit_id"]), _encode(record))


def forget_failure(directory: Path | str, unit_id: str) -> None:
    """Remove the record of a failure after a later attempt has succeeded."""
    Folder(directory).remove(_key(_FAILED, unit_id))


def _ids_of_runs(directory: Path | str) -> set[str]:
    """Return the ids of the units that any run of a directory rests on."""
    return {
        unit["unit_id"]
        for manifest in runs(directory)
        for case in manifest["cases"]
        for units in case["units"].values()
        for unit in units
    }


def _key(stage: str, unit_id: str) -> str:
    return f"{RECORDS}/{stage}/{unit_id}.json"


def _entries(home: Home, stage: str | None = None) -> list[tuple[str, str]]:
    """Return stage and id of the records at one place, of one stage or of all, sorted."""
    place = location.at(home)
    stages = [stage] if stage else [name for name in place.names(RECORDS) if name not in (_FAILED, _RUNS)]
    return sorted(
        (stage_name, name.removesuffix(".json"))
        for stage_name in stages
        for name in place.names(f"{RECORDS}/{stage_name}")
        if name.endswith(".json")
    )


def _record(unit_id: str, encoded: bytes | None) -> dict[str, Any] | None:
    """Return the commit record of a unit, or None where it is missing, damaged or another unit's."""
    record = _decode(encoded, is_record)
    return record if record is not None and record["unit_id"] == unit_id else None


def _folder(directory: Path | str, name: str, form: Form) -> list[dict[str, Any]]:
    """Return the valid files in one folder of a run directory's records, in order of their names."""
    place = Folder(directory)
    keys = [_key(name, unit_id) for _, unit_id in _entries(directory, name)]
    contents = (_decode(encoded, form) for encoded in place.read_many(keys))
    return [content for content in contents if content is not None]


def _decode(encoded: bytes | None, form: Form) -> dict[str, Any] | None:
    """Return the content of a record, or None where it is missing, torn, altered or of another form."""
    if encoded is None:
        return None
    try:
        content = json.loads(encoded)
    except (ValueError, RecursionError):
        return None
    if not isinstance(content, dict):
        return None
    checksum = content.pop(_CHECKSUM, None)
    body = encoded[: encoded.rfind(f',"{_CHECKSUM}":'.encode())]
    is_whole = checksum == hashlib.sha256(body).hexdigest() or content.get("schema") == _WITHOUT_CHECKSUM
    return content if is_whole and form(content) else None


def _encode(content: Mapping[str, Any]) -> bytes:
    """Return a record as one line of JSON; its last entry is the sha256 of the text before."""
    body = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))[:-1].encode()
    return body + f',"{_CHECKSUM}":"{hashlib.sha256(body).hexdigest()}"}}\n'.encode()
