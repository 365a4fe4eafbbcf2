"""One task, as a worker runs it: compute the units still missing, store them, and return the cost.

A task may run more than once, here or elsewhere. It looks for records first, and the first record stays, so
a unit counts once whatever happens. An exception of the physics becomes the record of a failure.
"""

import contextlib
import os
import resource
import socket
import time
import traceback
import warnings
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import railvib
from railvib import cost, signals
from railvib.errors import AccuracyWarning, PlausibilityWarning
from sweep.host import host_class
from sweep.processes import compiling
from sweep.storage import fields, location, records, store
from sweep.storage.cache import CACHE_BYTES, Cache, Latest
from sweep.storage.group_writer import Writer, Written, restore
from sweep.unit import Unit, registry, stage_class, unit_of

NEGLIGIBLE_S = 2e-5
"""Time outside the measured stages that is too short to be listed."""


@dataclass(frozen=True)
class Place:
    """Where the results of a run go, and which run asks for them: what a task needs beside its units.

    Attributes
    ----------
    store
        Where shared results go, if not to the directory.
    """

    directory: str
    run_id: str
    stages: str
    attempt: int = 1
    store: str | None = None

    @property
    def homes(self) -> tuple[str, ...]:
        """Where units may be stored."""
        return (self.directory, self.store) if self.store else (self.directory,)

    def home(self, unit: Unit) -> str:
        """Return where a unit is written; results of one case stay with the run."""
        return self.directory if unit.scope == "case" else self.homes[-1]

    def find(self, unit: Unit) -> tuple[str, dict[str, Any]] | None:
        """Return where a unit is stored and its commit record, or None if it has none."""
        candidates = ((home, records.find(home, unit.stage_name, unit.id)) for home in self.homes)
        return next(((home, record) for home, record in candidates if record is not None), None)


Status = Literal["done", "failed", "damaged", "no space"]


@dataclass(frozen=True)
class Outcome:
    """The outcome of a task.

    Attributes
    ----------
    status
        ``done``, ``failed`` if the computation raised, ``damaged`` if a stored result that it needs was
        damaged and has been withdrawn, ``no space`` if nothing more could be written.
    computed
        Number of units that this attempt was the first to store.
    cpu_s
        Processor seconds that it took [s].
    bytes_written, peak_rss_bytes
        Bytes stored, and the largest resident memory of the process meanwhile.
    error
        The last line of the exception.
    warnings
        Warnings of results that miss the requested accuracy.
    """

    key: str
    status: Status
    computed: int = 0
    cpu_s: float = 0.0
    bytes_written: int = 0
    peak_rss_bytes: int = 0
    error: str = ""
    warnings: tuple[str, ...] = ()


class WithdrawnError(Exception):
    """A stored result is damaged; its record has been withdrawn."""


REMEMBERED = 1024
"""Number of units whose records a worker remembers, a few kilobytes each."""

_cache = Cache(CACHE_BYTES)
_recorded: Latest[tuple[str, str], tuple[str, dict[str, Any]]] = Latest(REMEMBERED)


def forget() -> None:
    """Clear what this process has cached for further tasks."""
    _cache.clear()
    _recorded.clear()


def execute(key: str, units: Sequence[Unit], place: Place) -> Outcome:
    """Compute, store and record the units that have no record yet.

    Parameters
    ----------
    key
        The task's key.
    units
        The units of the task.
    place
        Where results go.
    """
    missing = [unit for unit in units if place.find(unit) is None]
    started = _now()
    cpu = time.process_time()
    _reset_peak()
    done: list[bool] = []
    written: list[int] = []
    cautions: list[str] = []

    def outcome(status: Status, error: str = "") -> Outcome:
        cpu_s = time.process_time() - cpu
        return Outcome(
            key, status, sum(done), cpu_s, sum(written), _peak(), error, tuple(dict.fromkeys(cautions))
        )

    try:
        for first, stored, warned in _compute(missing, place, started):
            done.append(first)
            written.append(stored)
            cautions += warned
    except WithdrawnError as error:
        return outcome("damaged", str(error))
    except Exception as error:
        if signals.end_requested():  # interrupted compiled code raises another error
            raise KeyboardInterrupt from error
        try:
            if location.is_full(error):
                raise
            _record_failure(missing, place, started, traceback.format_exc())
        except Exception as fault:
            if not location.is_full(fault):
                raise
            return outcome("no space", str(fault))
        return outcome("failed", f"{type(error).__name__}: {error}".partition("\n")[0])
    return outcome("done")


def _compute(missing: list[Unit], place: Place, started: str) -> Iterator[tuple[bool, int, list[str]]]:
    """Compute batch by batch and commit; yield per unit whether it is the first, its bytes, and warnings."""
    if not missing:
        return
    computing = stage_class(missing[0], registry(place.stages))
    compiling.compile_stage(computing)
    units = {unit.stage: unit for unit in missing}
    read = Reader(place)
    batches = computing.compute_together(list(units), lambda stage: read(unit_of(stage)))
    writers = {home: Writer(home) for home in place.homes}
    while True:
        cpu, wall = time.process_time(), time.perf_counter()
        with cost.collect() as costs, warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("ignore", PlausibilityWarning)  # already shown by the plan
            warnings.simplefilter("always", AccuracyWarning)
            results = next(batches, None)
        if results is None:
            return
        batch = {units[stage]: result for stage, result in results.items()}
        _complete(costs, time.perf_counter() - wall, time.process_time() - cpu)
        cautions = [
            str(warning.message) for warning in caught if issubclass(warning.category, AccuracyWarning)
        ]
        yield from _record(batch, costs, cautions, place, writers, started)
        del batch, results  # to free memory before the next batch


def _record(
    batch: Mapping[Unit, Any],
    costs: list[cost.StageCost],
    cautions: list[str],
    place: Place,
    writers: Mapping[str, Writer],
    started: str,
) -> Iterator[tuple[bool, int, list[str]]]:
    """Store and commit a batch; yield as `_compute` does."""
    shares = {unit: _share(unit, batch, costs) for unit in batch}
    stored: dict[str, list[tuple[Unit, dict[str, Any], Written]]] = {home: [] for home in writers}
    for group in _groups(batch):
        home = place.home(next(iter(group)))
        stored[home] += _store(group, shares, cautions, place, writers[home], started)
    for writer in writers.values():
        writer.settle()
    # Units of a batch share its costs, so none is recorded before all are stored: an interrupted batch is
    # computed again as a whole.
    for home, entries in stored.items():
        firsts = records.commit_many(home, [record for _, record, _ in entries])
        for (unit, _, written), first in zip(entries, firsts, strict=True):
            if first and unit.scope != "case":  # no other task reads results of one case
                _hold(unit, place, restore(written, unit.stage.result_type()))
                _recorded[place.directory, unit.id] = home, written.group_fields()
            yield first, written.bytes_written, cautions
            records.forget_failure(place.directory, unit.id)


class Reader:
    """Reads results of units that are done, verified against their records."""

    def __init__(self, place: Place) -> None:
        self._place = place

    def __call__(self, unit: Unit) -> Any:
        """Return the result of a unit.

        Raises
        ------
        WithdrawnError
            If it is damaged or missing; its record, if any, is withdrawn so that it is computed again.
        """
        cached = _cache.get((self._place.directory, unit.id))
        if cached is not None:
            return cached
        with cost.stage("load"):
            try:
                result = self._reread(unit)
                if result is None:
                    result = self._read_by_record(unit)
            except store.DamagedError as error:
                for home in self._place.homes:
                    records.withdraw(home, unit.stage_name, unit.id)
                raise WithdrawnError(str(error)) from error
        _hold(unit, self._place, result)
        return result

    def _reread(self, unit: Unit) -> Any:
        """Return a result by its remembered record; None if there is none, or it is out of date."""
        remembered = _recorded.pop((self._place.directory, unit.id), None)
        if remembered is None:
            return None
        with contextlib.suppress(store.DamagedError):
            return self._read(unit, *remembered)

    def _read_by_record(self, unit: Unit) -> Any:
        """Return a result by its record."""
        location_and_record = self._place.find(unit)
        if location_and_record is None:
            raise store.DamagedError(f"{unit.stage_name}/{unit.id}: has no record that can be read")
        home, record = location_and_record
        return self._read(unit, home, {name: record.get(name) for name in store.GROUP_FIELDS})

    def _read(self, unit: Unit, home: str, recorded: dict[str, Any]) -> Any:
        result: Any = store.read(home, result_type=unit.stage.result_type(), **recorded)
        _recorded[self._place.directory, unit.id] = home, recorded
        return result


def _hold(unit: Unit, place: Place, result: Any) -> None:
    """Cache a result as it would be read back, so that it does not matter who computed it."""
    _cache.put((place.directory, unit.id), result)


def _groups(batch: Mapping[Unit, Any]) -> list[dict[Unit, fields.Parts]]:
    """Divide a batch into results of one stage that can be stored as one group."""
    groups: dict[Hashable, dict[Unit, fields.Parts]] = {}
    for unit, result in batch.items():
        parts = fields.split(result)
        alone = unit.stage.label() is None or parts.dimension is None
        groups.setdefault(unit if alone else (unit.stage_name, parts.group_key), {})[unit] = parts
    return list(groups.values())


def _store(
    group: Mapping[Unit, fields.Parts],
    shares: Mapping[Unit, list[dict[str, Any]]],
    cautions: list[str],
    place: Place,
    writer: Writer,
    started: str,
) -> list[tuple[Unit, dict[str, Any], Written]]:
    """Store results as one group; return for each its unit, record and stored form."""
    cpu, wall = time.process_time(), time.perf_counter()
    first = next(iter(group))
    name = f"{first.stage_name}/{first.id}"
    attributes = {"kind": first.stage_name, "model_version": railvib.MODEL_VERSION}
    results = {unit.stage.label(): parts.with_attributes(unit_id=unit.id) for unit, parts in group.items()}
    members = writer.together(name, results, attributes)
    wall_s = (time.perf_counter() - wall) / len(group)
    cpu_s = (time.process_time() - cpu) / len(group)
    spent = vars(cost.StageCost("store", wall_s, cpu_s, peak_rss_bytes=_peak()))
    stored = []
    for unit, written in zip(group, members, strict=True):
        storing = {**spent, "bytes_written": written.bytes_written}
        record = {
            **_head(unit, place, started),
            "status": "done",
            **written.group_fields(),
            "costs": [*shares[unit], storing],
            "warnings": cautions,
        }
        stored.append((unit, record, written))
    return stored


def _record_failure(missing: Iterable[Unit], place: Place, started: str, text: str) -> None:
    """Record the failure of the units that have not been stored."""
    for unit in missing:
        if place.find(unit) is None:
            records.fail(place.directory, _failure_record(unit, place, started, text))


def _failure_record(unit: Unit, place: Place, started: str, text: str) -> dict[str, Any]:
    return {**_head(unit, place, started), "status": "failed", "traceback": text}


def crash_record(unit: Unit, place: Place, message: str) -> dict[str, Any]:
    """Return the failure record that the driver writes for a unit whose worker died."""
    return _failure_record(unit, place, _now(), message)


def _head(unit: Unit, place: Place, started: str) -> dict[str, Any]:
    """Return the entries that commit and failure records have in common."""
    return {
        "schema": records.SCHEMA,
        "unit_id": unit.id,
        "kind": unit.stage_name,  # the key of stored records for the stage's name
        "model_version": railvib.MODEL_VERSION,
        "inputs": unit.inputs,
        "worker": f"{socket.gethostname()}:{os.getpid()}",
        "host": socket.gethostname(),
        "host_class": host_class(),
        "attempt": place.attempt,
        "started": started,
        "finished": _now(),
        "run_id": place.run_id,
    }


def _complete(costs: list[cost.StageCost], wall_s: float, cpu_s: float) -> None:
    """Add the time outside the measured stages, so that their sum is the whole."""
    wall_s -= sum(spent.wall_s for spent in costs)
    cpu_s -= sum(spent.cpu_s for spent in costs)
    if not costs or wall_s > NEGLIGIBLE_S:
        cost.add(costs, cost.StageCost("other", max(wall_s, 0.0), max(cpu_s, 0.0), peak_rss_bytes=_peak()))


def _share(unit: Unit, batch: Mapping[Unit, Any], costs: Iterable[cost.StageCost]) -> list[dict[str, Any]]:
    """Return a unit's share of its batch's costs: the cost of one stage belongs to that stage's units."""
    stages = {other.stage_name for other in batch}
    shares = []
    for spent in costs:
        if spent.stage in stages and spent.stage != unit.stage_name:
            continue
        sharers = [other for other in batch if spent.stage not in stages or other.stage_name == spent.stage]
        # Counts stay whole numbers: the first units take the remainder.
        part, index = len(sharers), sharers.index(unit)
        shares.append(
            {
                **vars(spent),
                "wall_s": spent.wall_s / part,
                "cpu_s": spent.cpu_s / part,
                "evaluations": spent.evaluations // part + (index < spent.evaluations % part),
                "kernel_calls": spent.kernel_calls // part + (index < spent.kernel_calls % part),
                "bytes_written": 0,
            }
        )
    return shares


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _reset_peak() -> None:
    """Reset the peak of resident memory, where the system can."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * cost.RSS_UNIT
