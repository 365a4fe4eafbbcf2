"""Verification of every record, array and attribute that a run rests on."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from sweep.storage import records, store
from sweep.unit import Unit

THREADS = 4
"""Threads that read and hash; more do not help, as Python limits reading."""


@dataclass(frozen=True)
class Damage:
    """A damaged result, with the reason."""

    unit: Unit
    reason: str

    def __str__(self) -> str:
        """Return stage and id of the result, and the reason."""
        return f"{self.unit.stage_name}/{self.unit.id}: {self.reason}"


def find_damage(directory: Path, units: Iterable[Unit]) -> Iterator[Damage]:
    """Read the stored results of all units that have a record; yield the damaged ones."""
    present = records.ids_of(directory)
    stored = [unit for unit in units if unit.id in present]
    with ThreadPoolExecutor(THREADS) as pool:
        for unit, reason in zip(stored, pool.map(lambda unit: _fault(directory, unit), stored), strict=True):
            if reason is not None:
                yield Damage(unit, reason)


def withdraw(directory: Path, units: Iterable[Unit]) -> list[Damage]:
    """Withdraw the records of damaged results, so that they are computed again; return the damage."""
    damages = list(find_damage(directory, units))
    for damage in damages:
        for home in records.homes(directory):
            records.withdraw(home, damage.unit.stage_name, damage.unit.id)
    return damages


def _fault(directory: Path, unit: Unit) -> str | None:
    """Return the fault of a stored result, or None."""
    candidates = (records.find(home, unit.stage_name, unit.id) for home in records.homes(directory))
    record = next((record for record in candidates if record is not None), None)
    if record is None:
        return "its record cannot be read"
    try:
        store.check(directory, record)
    except store.DamagedError as error:
        return str(error).removeprefix(f"{record['group']}: ")
    return None
