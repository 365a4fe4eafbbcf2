"""State of the run in a directory, for people: running, dead or finished."""

import json
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sweep.progress import LOG
from sweep.running import lock
from sweep.storage import records

_LAST_BYTES = 64 * 1024
_ENDED = {0: "done", 1: "ended, some tasks failed", 130: "interrupted"}


def describe(directory: Path, manifest: Mapping[str, Any]) -> Iterator[str]:
    """Yield lines about the latest run of a directory: its state, how far it is, and what failed."""
    present = records.ids_of(directory)
    units = {
        case["case_id"]: {unit["unit_id"] for units in case["units"].values() for unit in units}
        for case in manifest["cases"]
    }
    needed = set().union(*units.values())
    complete = sum(ids <= present for ids in units.values())
    yield f"study     {manifest['study_name']}, run {manifest['run_id']} on {manifest['host']}"
    yield f"state     {_state(directory, manifest)}"
    yield f"started   {manifest['started']}, {manifest['finished'] or 'not finished'}"
    yield f"cases     {complete} of {len(units)} complete"
    yield f"units     {len(needed & present)} of {len(needed)} done"
    if manifest["finished"] is None:
        yield from _pace(directory, manifest)
    failures = [record for record in records.failures(directory) if record["unit_id"] in needed]
    yield f"failures  {len(failures)}"
    for record in failures:
        yield f"  {record['kind']}/{record['unit_id']}: {record['traceback'].strip().splitlines()[-1]}"


def alive(directory: Path) -> bool:
    """Return whether a process runs in a directory, as far as this host can tell."""
    holder = lock.holder(directory)
    return holder is not None and holder.alive is not False


def _state(directory: Path, manifest: Mapping[str, Any]) -> str:
    holder = lock.holder(directory)
    if holder is not None and holder.alive is not False:
        doubt = "" if holder.alive else "; whether it is alive cannot be seen from here"
        return f"running: {holder}, since {holder.since}{doubt}"
    if manifest["finished"] is None:
        return f"dead: {holder or 'its process'} exited unexpectedly"
    status = manifest["exit_status"]
    return f"{_ENDED.get(status, 'ended')}, exit status {status}"


def _pace(directory: Path, manifest: Mapping[str, Any]) -> Iterator[str]:
    """Yield how many tasks have settled, from the last line that the run has logged."""
    line = _last(directory / LOG, manifest["run_id"])
    if line is None:
        return
    moment = datetime.now(UTC) if alive(directory) else datetime.fromisoformat(line["time"])
    elapsed = (moment - datetime.fromisoformat(manifest["started"])).total_seconds()
    rate = line["settled"] / max(elapsed, 1e-3)
    remaining = (
        f", {(line['tasks'] - line['settled']) / rate:.0f} s left" if rate > 0.0 and alive(directory) else ""
    )
    yield f"tasks     {line['settled']} of {line['tasks']} settled, {rate:.1f}/s{remaining}"


def _last(path: Path, run_id: str) -> dict[str, Any] | None:
    """Return the last whole log line of a run that reports progress."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - _LAST_BYTES))
            lines = file.read().splitlines()
    except FileNotFoundError:
        return None
    for text in reversed(lines):
        try:
            line: dict[str, Any] = json.loads(text)
        except ValueError:  # cut at the front, or still being written
            continue
        if line.get("run_id") == run_id and "settled" in line:
            return line
    return None
